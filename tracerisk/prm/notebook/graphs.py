"""Models as graphs of networkx, which is imported only then."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.dynamic import DynamicTree
from tracerisk.prm.other_models.linked.links import leaf_key
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.other_models.markov import MarkovChain
from tracerisk.prm.trees.fault_tree import FaultTree

if TYPE_CHECKING:
    import networkx as nx


def graph_of(model: object) -> nx.DiGraph:
    """Return a fault tree, dynamic or not, a chain or a hybrid model as a directed graph.

    See DisplayedGraph; of a dynamic tree, dependencies and restrictions are nodes, too.
    """
    try:
        import networkx as nx
    except ImportError as error:
        raise ModelError(
            "graphs need networkx, which is not installed; "
            "install it with: pip install 'tracerisk[graph]'"
        ) from error
    graph = nx.DiGraph()
    if isinstance(model, FaultTree):
        _add_tree(model, graph)
    elif isinstance(model, DynamicTree):
        _add_dynamic_tree(model, graph)
    elif isinstance(model, MarkovChain):
        _add_chain(model, graph)
    elif isinstance(model, HybridModel):
        _add_hybrid(model, graph)
    elif isinstance(model, LinkedModel):
        _add_linked(model, graph)
    else:
        raise TypeError(f"{type(model).__name__} is not a graph")
    return graph


def _add_tree(tree: FaultTree, graph: Any) -> None:
    graph.graph.update(name=tree.top, top=tree.top)
    for gate in tree.gates:
        graph.add_node(gate.name, kind=gate.kind.value, k=gate.k, most=gate.most)
    for event in tree.events:
        graph.add_node(event.name, kind="event", parameter=event.parameter, model=event.model)
    for house in tree.houses:
        graph.add_node(house.name, kind="house", state=house.state)
    for gate in tree.gates:
        for rank, name in enumerate(gate.inputs):
            if graph.has_edge(gate.name, name):
                graph.edges[gate.name, name]["count"] += 1
            else:
                graph.add_edge(gate.name, name, rank=rank, count=1)


def _add_dynamic_tree(tree: DynamicTree, graph: Any) -> None:
    graph.graph.update(name=tree.top, top=tree.top)
    for gate in tree.gates:
        graph.add_node(gate.name, kind=gate.kind.value, gate=gate)
    for event in tree.events:
        graph.add_node(event.name, kind="event", dormancy=event.dormancy, model=event.model)
    for dependency in tree.dependencies:
        graph.add_node(dependency.name, kind="fdep", probability=dependency.probability)
    for restriction in tree.restrictions:
        graph.add_node(restriction.name, kind=restriction.kind.value)
    for user in (*tree.gates, *tree.ties):
        for rank, name in enumerate(user.inputs):
            graph.add_edge(user.name, name, rank=rank)


def _add_chain(chain: MarkovChain, graph: Any) -> None:
    graph.add_nodes_from(chain.transitions, kind="transient")
    graph.add_nodes_from(chain.absorbing, kind="absorbing")
    for state, row in chain.transitions.items():
        for target, p in row.items():
            graph.add_edge(state, target, probability=p)


def _add_hybrid(model: HybridModel, graph: Any) -> None:
    graph.graph.update(name=model.name, entry=model.entry)
    failures = model.failure_states
    for state in model.states:
        graph.add_node(state.name, kind="state", tree=state.tree)
    graph.add_node(DONE, kind="done")
    for state in model.states:
        graph.add_node(failures[state.name], kind="failure")
        graph.add_edge(state.name, failures[state.name])
        for step in state.next:
            graph.add_edge(state.name, step.target, weight=float(step.weight))


def _add_linked(model: LinkedModel, graph: Any) -> None:
    graph.graph.update(name=model.name)
    for prepared in model.prepared:
        graph.add_node(str(prepared.key), kind=prepared.key.kind, name=prepared.key.name)
    for name in model.figure_tapes:
        graph.add_node(f"figure '{name}'", kind="figure", name=name)
    users = [(str(item.key), item.tapes) for item in model.prepared]
    users += [(f"figure '{name}'", (tape,)) for name, tape in model.figure_tapes.items()]
    for user, tapes in users:
        for tape in tapes:
            for leaf in tape.leaves:
                graph.add_edge(str(leaf_key(leaf)), user)
