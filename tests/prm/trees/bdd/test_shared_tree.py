from fractions import Fraction
from itertools import product
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.bdd import SharedTree, diagram
from tracerisk.prm.trees.bdd.diagram import Limits
from tracerisk.prm.trees.bdd.speed import fastest_loops, plain_loops
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

COHERENT = (GateKind.OR, GateKind.AND, GateKind.ATLEAST, GateKind.INHIBIT, GateKind.TRANSFER)
OR, AND, XOR = GateKind.OR, GateKind.AND, GateKind.XOR

HAPPENS = {
    GateKind.OR: any,
    GateKind.AND: all,
    GateKind.NOT: lambda x: not x[0],
    GateKind.TRANSFER: all,
    GateKind.INHIBIT: all,
    GateKind.NAND: lambda x: not all(x),
    GateKind.NOR: lambda x: not any(x),
    GateKind.IMPLY: lambda x: not x[0] or x[1],
    GateKind.IFF: lambda x: x[0] == x[1],
    GateKind.XOR: lambda x: sum(x) % 2 == 1,
}


def truth_table(tree):
    """Return whether the top happens, for each assignment of the events: brute force."""
    found = []
    for states in product((False, True), repeat=len(tree.events)):
        value = {event.name: state for event, state in zip(tree.events, states, strict=True)}
        value |= {house.name: house.state for house in tree.houses}
        for gate in tree.upwards:
            inputs = [value[name] for name in gate.inputs]
            if gate.kind is GateKind.ATLEAST:
                value[gate.name] = sum(inputs) >= gate.k
            elif gate.kind is GateKind.CARDINALITY:
                value[gate.name] = gate.k <= sum(inputs) <= gate.most
            else:
                value[gate.name] = HAPPENS[gate.kind](inputs)
        found.append(value[tree.top])
    return found


def exact(table, p):
    """Return the exact probability of a truth table; each of `p` a multiple of 2^-61."""
    one = 1 << 61
    shares = [int(value) for value in table]
    for value in reversed(p):
        happens = int(value * one)
        pairs_of = zip(shares[::2], shares[1::2], strict=True)
        shares = [(one - happens) * without + happens * having for without, having in pairs_of]
    return Fraction(shares[0], one ** len(p))


def pairs(tree, p):
    return {
        event.name: Probability(float(value), float(1 - value))
        for event, value in zip(tree.events, p, strict=True)
    }


def is_close(found, expected, relative=1e-13, scale=Fraction(0)):
    """Whether a double is within a relative error, of `scale` where that is greater."""
    return abs(Fraction(found) - expected) <= Fraction(relative) * max(abs(expected), scale)


@st.composite
def shared_trees(draw, kinds, most_events=10):
    """Draw a tree whose gates take any of the events, houses and gates before them."""
    events = [f"e{i}" for i in range(draw(st.integers(2, most_events)))]
    houses = [HouseEvent("on", True), HouseEvent("off", False)] if draw(st.booleans()) else []
    names = events + [house.name for house in houses]
    gates = []
    for number in range(draw(st.integers(1, 9))):
        kind = draw(st.sampled_from(kinds))
        least = 2 if kind in (GateKind.INHIBIT, GateKind.IMPLY, GateKind.IFF, XOR) else 1
        most = {GateKind.NOT: 1, GateKind.TRANSFER: 1}.get(kind, 5)
        if kind in (GateKind.INHIBIT, GateKind.IMPLY, GateKind.IFF):
            most = 2
        inputs = tuple(draw(st.lists(st.sampled_from(names), min_size=least, max_size=most)))
        k = most_of = None
        if kind is GateKind.ATLEAST:
            k = draw(st.integers(1, len(inputs)))
        elif kind is GateKind.CARDINALITY:
            k = draw(st.integers(0, len(inputs)))
            most_of = draw(st.integers(k, len(inputs)))
        gates.append(Gate(f"g{number}", kind, inputs, k, most_of))
        names.append(f"g{number}")
    used = {name for gate in gates for name in gate.inputs}
    loose = [name for name in names if name not in used]
    gates.append(Gate("top", draw(st.sampled_from((OR, AND))), tuple(loose)))
    return FaultTree("top", tuple(gates), tuple(BasicEvent(name) for name in events), tuple(houses))


# Doubles whose complements are doubles too, so that the exact answer needs no allowance for them.
exact_values = st.integers(0, 1 << 20).map(lambda n: Fraction(n, 1 << 20))
rare_values = st.sampled_from([Fraction(1, 1 << 60), Fraction(1, 1 << 40), Fraction(3, 1 << 20)])


@given(tree=shared_trees(tuple(GateKind)), data=st.data())
def test_any_tree_equals_enumeration(tree, data):
    count = len(tree.events)
    p, low = (data.draw(st.lists(exact_values, min_size=count, max_size=count)) for _ in "ab")
    table = truth_table(tree)
    solver = SharedTree(tree)
    found = solver.probability(pairs(tree, p))
    expected = exact(table, p)
    assert is_close(found.p, expected)
    assert is_close(found.q, 1 - expected)
    # What is not coherent may subtract: its error is measured by what was subtracted.
    drop = solver.difference(pairs(tree, p), pairs(tree, low))
    assert is_close(drop, expected - exact(table, low), scale=Fraction(1, 100))
    for place, share in enumerate(solver.sensitivities(pairs(tree, p)).values()):
        high_p, low_p = ([*p[:place], Fraction(end), *p[place + 1 :]] for end in (1, 0))
        derivative = exact(table, high_p) - exact(table, low_p)
        assert is_close(share, derivative, scale=Fraction(1, 100))


@given(tree=shared_trees(COHERENT), data=st.data())
def test_nothing_cancels_in_a_coherent_tree(tree, data):
    count = len(tree.events)
    values = st.one_of(exact_values, rare_values)
    p = data.draw(st.lists(values, min_size=count, max_size=count))
    low = [value / 2 if data.draw(st.booleans()) else value for value in p]
    table = truth_table(tree)
    solver = SharedTree(tree)
    # The pair of an event is rounded once in its complement, which 1 - 2^-60 shows.
    assert is_close(solver.probability(pairs(tree, p)).p, exact(table, p))
    expected = exact(table, p) - exact(table, low)
    assert is_close(solver.difference(pairs(tree, p), pairs(tree, low)), expected)
    for place, share in enumerate(solver.sensitivities(pairs(tree, p)).values()):
        high_p, low_p = ([*p[:place], Fraction(end), *p[place + 1 :]] for end in (1, 0))
        assert is_close(share, exact(table, high_p) - exact(table, low_p))


@settings(max_examples=25, deadline=None)
@given(tree=shared_trees(tuple(GateKind)), data=st.data())
def test_compiled_loops_and_other_orders_give_the_same(tree, data):
    count = len(tree.events)
    p, low = (data.draw(st.lists(exact_values, min_size=count, max_size=count)) for _ in "ab")
    fast = SharedTree(tree)
    with patch.object(diagram, "fastest_loops", plain_loops):
        plain = SharedTree(tree)
    assert plain.probability(pairs(tree, p)) == fast.probability(pairs(tree, p))
    assert plain.sensitivities(pairs(tree, p)) == fast.sensitivities(pairs(tree, p))
    drops = [solver.difference(pairs(tree, p), pairs(tree, low)) for solver in (plain, fast)]
    assert drops[0] == drops[1]
    other = SharedTree(tree, Limits(swapped=True)).probability(pairs(tree, p))
    assert other == pytest.approx(plain.probability(pairs(tree, p)), rel=1e-14)


@pytest.mark.parametrize("loops", [fastest_loops, plain_loops])
@settings(max_examples=10, deadline=None)
@given(tree=shared_trees(tuple(GateKind)), data=st.data())
def test_many_samples_equal_each_alone(loops, tree, data):
    samples = 5
    drawn = [
        data.draw(st.lists(exact_values, min_size=samples, max_size=samples)) for _ in tree.events
    ]
    with patch.object(diagram, "fastest_loops", loops):
        solver = SharedTree(tree, Limits(samples_bytes=1))
    arrays = {
        event.name: np.array(row, dtype=float)
        for event, row in zip(tree.events, drawn, strict=True)
    }
    found = solver.probabilities(arrays)
    assert found.shape == (samples, 2)
    for sample in range(samples):
        alone = solver.probability(pairs(tree, [row[sample] for row in drawn]))
        assert tuple(found[sample]) == alone


def gates_of(*rows):
    return tuple(Gate(name, kind, tuple(inputs.split())) for name, kind, inputs in rows)


def test_an_xor_of_two_rare_events_is_their_sum():
    tree = FaultTree("top", gates_of(("top", XOR, "a b")), (BasicEvent("a"), BasicEvent("b")))
    rare = {"a": Probability.of(1e-18), "b": Probability.of(1e-18)}
    assert SharedTree(tree).probability(rare).p == 2e-18
    # The same written out with shared events.
    gates = gates_of(
        ("top", OR, "l r"),
        ("l", AND, "a nb"),
        ("r", AND, "na b"),
        ("na", GateKind.NOT, "a"),
        ("nb", GateKind.NOT, "b"),
    )
    written = FaultTree("top", gates, tree.events)
    assert written.probability({"a": 1e-18, "b": 1e-18}).p == 2e-18


def test_the_difference_of_a_redundant_pair_keeps_its_digits_beside_a_large_shared_top():
    # (big and x) or (big and y) or (a and b and x) or (a and b): the pair is worth
    # p^2 (1 - P(big and (x or y))), beside a top of nearly one half.
    gates = gates_of(
        ("top", OR, "m n o pair"),
        ("m", AND, "big x"),
        ("n", AND, "big y"),
        ("o", AND, "a b x"),
        ("pair", AND, "a b"),
    )
    tree = FaultTree("top", gates, tuple(BasicEvent(name) for name in ("big", "x", "y", "a", "b")))
    p = 6.7e-08
    values = {"big": 0.5, "x": 0.875, "y": 0.75, "a": p, "b": p}
    rest = Fraction(1) - Fraction(1, 2) * (1 - Fraction(1, 8) * Fraction(1, 4))
    expected = float(Fraction(p) ** 2 * rest)
    assert tree.drop_without("a", values) == pytest.approx(expected, rel=1e-14)
    assert tree.probability(values).p == pytest.approx(0.484375, rel=1e-12)


def test_the_difference_of_a_redundant_pair_in_an_independent_tree_keeps_its_digits():
    gates = gates_of(("top", OR, "pair big"), ("pair", AND, "a b"))
    tree = FaultTree("top", gates, tuple(BasicEvent(name) for name in ("big", "a", "b")))
    drop = tree.drop_without("a", {"big": 0.5, "a": 6.7e-08, "b": 6.7e-08})
    assert drop == pytest.approx(6.7e-08**2 / 2, rel=1e-14)


def test_a_chain_of_three_thousand_shared_gates_is_solved():
    # g_i = (e_i and g_{i+1}) or (f_i and g_{i+1}): deeper than any recursion.
    depth = 3_000
    gates = []
    for i in range(depth):
        gates += gates_of(
            (f"g{i}", OR, f"l{i} r{i}"),
            (f"l{i}", AND, f"e{i} g{i + 1}"),
            (f"r{i}", AND, f"f{i} g{i + 1}"),
        )
    gates += gates_of((f"g{depth}", OR, "last"))
    events = [f"{kind}{i}" for i in range(depth) for kind in "ef"] + ["last"]
    tree = FaultTree("g0", tuple(gates), tuple(BasicEvent(name, "p") for name in events))
    assert tree.probability({"p": 1.0}) == (1.0, 0.0)
    p = 1.0 - 2.0**-20
    expected = (1 - Fraction(1, 1 << 40)) ** depth * Fraction(p)
    assert tree.probability({"p": p}).p == pytest.approx(float(expected), rel=1e-11)


def test_an_event_on_which_the_top_does_not_depend_has_no_sensitivity():
    gates = gates_of(("top", OR, "a both"), ("both", AND, "a b"))
    tree = FaultTree("top", gates, (BasicEvent("a"), BasicEvent("b")))
    assert tree.sensitivities({"a": 0.25, "b": 0.5}) == {"a": 1.0, "b": 0.0}
    assert tree.probability({"a": 0.25, "b": 0.5}) == (0.25, 0.75)


def test_samples_without_an_event_or_outside_the_unit_interval_are_refused():
    tree = FaultTree("top", gates_of(("top", AND, "a a b")), (BasicEvent("a"), BasicEvent("b")))
    with pytest.raises(ModelError, match="event 'b' has no value; allowed: a"):
        SharedTree(tree).probabilities({"a": np.array([0.5])})
    with pytest.raises(ModelError, match=r"event 'b': a probability is outside \[0, 1\]"):
        SharedTree(tree).probabilities({"a": np.array([0.5]), "b": np.array([1.5])})
