import random
import subprocess
import sys

import pytest

from tests.slow import slow_but
from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.bdd import SharedTree, with_bounds
from tracerisk.prm.trees.bdd.bounds import tree_bounds
from tracerisk.prm.trees.bdd.diagram import Limits
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind


def tangled_tree(events, sums):
    """A product of sums over events drawn anew for each: no module, and a wide diagram."""
    source = random.Random(7)
    names = [f"e{i}" for i in range(events)]
    gates = [Gate(f"g{i}", GateKind.OR, tuple(source.sample(names, 4))) for i in range(sums)]
    top = Gate("top", GateKind.AND, tuple(gate.name for gate in gates))
    used = [name for name in names if any(name in gate.inputs for gate in gates)]
    return FaultTree("top", (top, *gates), tuple(BasicEvent(name, "p") for name in used))


@pytest.fixture(scope="module")
def tangled():
    return tangled_tree(40, 30)


@pytest.fixture(scope="module")
def diagram(tangled):
    return SharedTree(tangled)


def test_a_tree_that_outgrows_its_budgets_is_refused_with_what_was_tried(tangled):
    with pytest.raises(TooLargeError) as caught:
        SharedTree(tangled, Limits(nodes=(1_000, 3_000)))
    message = str(caught.value)
    assert message.startswith("fault tree 'top': a module of")
    assert "exceeded every budget of its decision diagram: 1000, 3000 nodes" in message
    assert "orders of the events (most shared, deepest first; deepest, most shared" in message
    assert "FORCE from" in message
    assert message.endswith("give larger budgets (Limits.nodes), or divide the tree")
    assert isinstance(caught.value, ModelError)


def test_the_least_budget_that_fits_is_enough(tangled):
    limits = Limits(nodes=(1_000, 2_000_000))
    found = SharedTree(tangled, limits).probability(
        {event.name: Probability.of(0.25) for event in tangled.events}
    )
    assert found.p + found.q == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize(
    ("bound_nodes", "p"),
    slow_but([(50, 0.01), (50, 0.5)], [(50, 0.01), (50, 0.5), (1_000, 0.01), (1_000, 0.5)]),
)
def test_bounds_hold_the_probability_between_them(tangled, diagram, p, bound_nodes):
    pairs = {event.name: Probability.of(p) for event in tangled.events}
    exact = diagram.probability(pairs).p
    lower, upper = tree_bounds(tangled, pairs, Limits(nodes=(1_000,), bound_nodes=bound_nodes))
    assert lower <= exact <= upper
    assert lower < upper


def test_bounds_by_diagrams_that_need_no_thinning_are_the_probability():
    tree = tangled_tree(20, 15)
    pairs = {event.name: Probability.of(0.25) for event in tree.events}
    exact = SharedTree(tree).probability(pairs).p
    limits = Limits(nodes=(100,), bound_nodes=5_000)
    assert tree_bounds(tree, pairs, limits) == pytest.approx((exact, exact), rel=1e-13)


def test_bounds_hold_for_a_tree_that_is_not_coherent(tangled):
    odd = Gate("odd", GateKind.XOR, ("top", "e1", "e2"))
    tree = FaultTree("odd", (odd, *tangled.gates), tangled.events)
    pairs = {event.name: Probability.of(0.3) for event in tree.events}
    exact = SharedTree(tree).probability(pairs).p
    lower, upper = tree_bounds(tree, pairs, Limits(nodes=(1_000,), bound_nodes=300))
    assert lower < exact < upper


def test_the_error_says_the_bounds(tangled, diagram):
    pairs = {event.name: Probability.of(0.25) for event in tangled.events}
    limits = Limits(nodes=(1_000,), bound_nodes=1_000)
    with pytest.raises(TooLargeError) as caught:
        SharedTree(tangled, limits)
    error = with_bounds(caught.value, tangled, pairs, limits)
    assert error.lower < diagram.probability(pairs).p < error.upper
    assert f"; the probability is between {error.lower!r} and {error.upper!r}" in error.message


def test_a_shared_tree_is_solved_without_numpy():
    program = """
import sys
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind
gates = [Gate("top", GateKind.ATLEAST, ("x0", "x1", "x2", "x3"), 2)]
gates += [Gate(f"x{i}", GateKind.OR, (f"a{i}", f"a{(i + 1) % 4}")) for i in range(4)]
tree = FaultTree("top", tuple(gates), tuple(BasicEvent(f"a{i}", "p") for i in range(4)))
# Any one event is in two of the sums: all but no event at all make two of four.
assert tree.probability({"p": 0.5}).p == 15 / 16
assert "numpy" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_bounds_keep_the_complement_of_a_part_that_nearly_always_happens():
    source = random.Random(3)
    names = [f"e{i}" for i in range(12)]
    sums = [Gate(f"g{i}", GateKind.AND, tuple(source.sample(names, 3))) for i in range(9)]
    # The OR is the complement of an AND that nearly always happens.
    joined = Gate("joined", GateKind.OR, tuple(gate.name for gate in sums))
    gates = (Gate("top", GateKind.AND, ("joined", "other")), joined, *sums)
    used = {name for gate in sums for name in gate.inputs}
    events = tuple(BasicEvent(name, name) for name in [*names, "other"] if name in used | {"other"})
    tree = FaultTree("top", gates, events)
    pairs = {event.name: Probability.of(1e-6) for event in events}
    exact = SharedTree(tree).probability(pairs).p
    assert exact < 1e-20
    limits = Limits(nodes=(10,), bound_nodes=1_000)
    assert tree_bounds(tree, pairs, limits) == pytest.approx((exact, exact), rel=1e-12)
