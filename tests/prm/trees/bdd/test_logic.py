from itertools import product

import pytest

from tracerisk.prm.trees.bdd.logic import FALSE, FIRST_EVENT, TRUE, LogicBuilder, logic_graph
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind


def evaluate(graph, happened):
    """Return whether the graph's top happens, by evaluating every node."""
    value = {TRUE: True, **dict(enumerate(happened, FIRST_EVENT))}
    for node in range(graph.first_gate, len(graph.arguments)):
        value[node] = all(value[abs(a)] == (a > 0) for a in graph.arguments[node])
    return value[abs(graph.top)] == (graph.top > 0)


CASES = [
    (GateKind.OR, 3, None, None, lambda x: any(x)),
    (GateKind.AND, 3, None, None, lambda x: all(x)),
    (GateKind.NOT, 1, None, None, lambda x: not x[0]),
    (GateKind.TRANSFER, 1, None, None, lambda x: x[0]),
    (GateKind.INHIBIT, 2, None, None, lambda x: all(x)),
    (GateKind.NAND, 3, None, None, lambda x: not all(x)),
    (GateKind.NOR, 3, None, None, lambda x: not any(x)),
    (GateKind.IMPLY, 2, None, None, lambda x: not x[0] or x[1]),
    (GateKind.IFF, 2, None, None, lambda x: x[0] == x[1]),
    (GateKind.XOR, 4, None, None, lambda x: sum(x) % 2 == 1),
    *[(GateKind.ATLEAST, 5, k, None, lambda x, k=k: sum(x) >= k) for k in range(1, 6)],
    *[
        (GateKind.CARDINALITY, 4, k, most, lambda x, k=k, m=most: k <= sum(x) <= m)
        for k in range(5)
        for most in range(k, 5)
    ],
]


@pytest.mark.parametrize(("kind", "size", "k", "most", "expected"), CASES)
def test_every_gate_is_its_truth_table(kind, size, k, most, expected):
    names = tuple(f"e{i}" for i in range(size))
    gate = Gate("top", kind, names, k, most)
    graph = logic_graph(FaultTree("top", (gate,), tuple(BasicEvent(name) for name in names)))
    for happened in product((False, True), repeat=size):
        assert evaluate(graph, happened) == expected(happened)


def test_arguments_are_sorted_by_node_and_stand_before_their_gate():
    builder = LogicBuilder(["a", "b", "c"])
    inner = builder.disjunction((4, -2))
    graph = builder.graph(builder.conjunction((inner, 3)))
    assert graph.arguments[5:] == ((2, -4), (3, -5))
    assert graph.top > 0, "an AND; the inner OR is the complement of one"
    assert graph.reachable() == [2, 3, 4, 5, 6]
    assert graph.event(-4) == "c"


def test_alike_gates_are_made_once_and_contradictions_never_happen():
    builder = LogicBuilder(["a", "b"])
    assert builder.conjunction((2, 3)) == builder.conjunction((3, 2, 3, TRUE))
    assert builder.conjunction((2, -2)) == FALSE
    assert builder.disjunction((2, -2)) == TRUE
    assert builder.conjunction(()) == TRUE
    assert builder.conjunction((-3,)) == -3


def test_house_events_become_constants():
    gates = (Gate("top", GateKind.OR, ("g", "on")), Gate("g", GateKind.AND, ("e", "off")))
    houses = (HouseEvent("on", True), HouseEvent("off", False))
    graph = logic_graph(FaultTree("top", gates, (BasicEvent("e"),), houses))
    assert graph.top == TRUE


def test_the_counts_of_a_vote_are_shared():
    builder = LogicBuilder([f"e{i}" for i in range(40)])
    builder.at_least(20, range(FIRST_EVENT, FIRST_EVENT + 40))
    # 20 of 40 has 137846528820 combinations; the grid has two nodes for each place and count.
    assert len(builder.arguments) < 2 * 20 * 21 + 42 + 1
