"""Find the minimal cut sets or the prime implicants of a fault tree, module by module."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.cut_sets.cut_sets import CutSets
from tracerisk.prm.other_models.cut_sets.family import (
    Family,
    of_conjunction,
    of_diagram,
    of_disjunction,
    phases,
)
from tracerisk.prm.other_models.cut_sets.primes import primes_of_diagram
from tracerisk.prm.trees.bdd.diagram import DEFAULT_LIMITS, Limits
from tracerisk.prm.trees.bdd.logic import FIRST_EVENT, TRUE
from tracerisk.prm.trees.bdd.modules import Module
from tracerisk.prm.trees.bdd.shared_tree import SharedTree
from tracerisk.prm.trees.gates import GateKind

if TYPE_CHECKING:
    from tracerisk.prm.trees.fault_tree import FaultTree
    from tracerisk.prm.trees.gates import Gate

DEFAULT_BUDGET = 20_000_000
"""The most nodes of the family of one module; a node takes 12 bytes, and 40 while it is made."""


_MOST_COUNTS = 2_000_000
"""How many pairs of counts the inputs of one gate may be in: some seconds."""

LEAST_BUDGET = 2
"""The two constants of a family."""


def minimal_cut_sets(
    tree: FaultTree,
    *,
    max_order: int | None = None,
    budget: int = DEFAULT_BUDGET,
    limits: Limits = DEFAULT_LIMITS,
) -> CutSets:
    """Return the minimal cut sets: events that make the top happen when nothing else does.

    Of a coherent tree these are its prime implicants; of another, `prime_implicants` also lists
    which events must not happen.
    A module's are found on its decision diagram; those of the whole are never written out, so
    that a hundred million of them take little memory.
    `max_order` leaves out sets of more events.
    Raises TooLargeError when a module needs more than `budget` nodes, or as
    `FaultTree.probability` does.
    """
    solved = _solved(tree, max_order, budget, limits)
    graph = solved.graph
    parameters = _parameters(tree)
    # The literal of each node that is false while nothing has happened.
    calm = list(range(len(graph.arguments)))
    families: dict[int, Family] = {}
    least = dict.fromkeys(range(FIRST_EVENT, graph.first_gate), 1)
    for module in solved.modules:
        root = module.root
        if module.is_simple:
            arguments = graph.arguments[root]
            if all(calm[abs(argument)] != argument for argument in arguments):
                calm[root] = -root
                family = of_disjunction([-argument for argument in arguments])
            else:
                family = of_conjunction([a for a in arguments if calm[abs(a)] == a])
        else:
            diagram = solved.diagrams[root]
            literals = tuple(calm[node] for node in diagram.order)
            if diagram.happens_at([literal < 0 for literal in literals]):
                calm[root] = -root
            sign = 1 if calm[root] > 0 else -1
            family = of_diagram(diagram, sign, literals, least, max_order, budget)
        families[calm[root]] = family
        least[calm[root]] = int(family.lightest(least, max_order)[family.root])
    if abs(graph.top) != TRUE and calm[abs(graph.top)] != graph.top:
        # The top happens while nothing has: the empty set, and no other is minimal.
        return CutSets(max_order, replace(graph, top=TRUE), {}, parameters)
    return CutSets(max_order, graph, _below(graph.top, families), parameters)


def prime_implicants(
    tree: FaultTree,
    *,
    max_order: int | None = None,
    budget: int = DEFAULT_BUDGET,
    limits: Limits = DEFAULT_LIMITS,
) -> CutSets:
    """Return the prime implicants: what must happen, and what must not, for the top to happen.

    Of a coherent tree these are the minimal cut sets.
    Raises as `minimal_cut_sets` does.
    """
    solved = _solved(tree, max_order, budget, limits)
    graph = solved.graph
    needed = {graph.top}
    wanted: list[tuple[int, Module, dict[int, int] | None]] = []
    for module in reversed(solved.modules):
        phase = phases(graph, module)
        for literal in (module.root, -module.root):
            if literal not in needed:
                continue
            wanted.append((literal, module, phase))
            for node in module.inputs:
                if phase is None:
                    needed |= {node, -node}
                else:
                    needed.add(node * phase[node] * _sign(literal))
    families: dict[int, Family] = {}
    least = {n * s: 1 for n in range(FIRST_EVENT, graph.first_gate) for s in (1, -1)}
    for literal, module, phase in reversed(wanted):
        sign = _sign(literal)
        if module.is_simple:
            arguments = graph.arguments[module.root]
            if literal > 0:
                family = of_conjunction(arguments)
            else:
                family = of_disjunction([-argument for argument in arguments])
        elif phase is not None:
            diagram = solved.diagrams[module.root]
            literals = tuple(node * phase[node] * sign for node in diagram.order)
            family = of_diagram(diagram, sign, literals, least, max_order, budget)
        else:
            family = primes_of_diagram(solved.diagrams[module.root], sign, budget)
        families[literal] = family
        least[literal] = int(family.lightest(least, max_order)[family.root])
    return CutSets(max_order, graph, families, _parameters(tree))


def _solved(tree: FaultTree, max_order: int | None, budget: int, limits: Limits) -> SharedTree:
    if max_order is not None and (not isinstance(max_order, int) or max_order < 1):
        raise ModelError(f"max_order is {max_order!r}; give a whole number, at least 1")
    if budget < LEAST_BUDGET:
        raise ModelError(f"budget is {budget} nodes; give at least {LEAST_BUDGET}")
    for gate in tree.gates:
        _check_counts(gate, tree.top)
    return SharedTree(tree, limits)


def _check_counts(gate: Gate, top: str) -> None:
    """Raise TooLargeError at once for a gate whose sets take too long to be found.

    A set of its inputs is minimal where it holds none of those with one fewer: a pair of counts
    for each input.
    """
    if gate.kind is GateKind.ATLEAST:
        needed = gate.threshold
    elif gate.kind is GateKind.CARDINALITY:
        needed = max(gate.k or 0, len(gate.inputs) - (gate.most or 0))
    else:
        return
    least = min(needed, len(gate.inputs) - needed + 1)
    if needed * (len(gate.inputs) - needed + 1) * least > _MOST_COUNTS:
        raise TooLargeError(
            f"fault tree '{top}': gate '{gate.name}' has one set for each choice of {needed} of "
            "its "
            f"{len(gate.inputs)} inputs, too many to list; solve the tree without cut sets "
            "(tracerisk solve), or divide the gate into smaller ones"
        )


def _parameters(tree: FaultTree) -> dict[str, str]:
    return {event.name: event.parameter for event in tree.events}


def _sign(literal: int) -> int:
    return 1 if literal > 0 else -1


def _below(top: int, families: dict[int, Family]) -> dict[int, Family]:
    """Return the families that the top's sets are made of, each after those it names."""
    wanted = {top}
    for literal in reversed(families):
        if literal in wanted:
            wanted.update(families[literal].literals)
    return {literal: family for literal, family in families.items() if literal in wanted}
