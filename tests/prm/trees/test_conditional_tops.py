from fractions import Fraction
from itertools import count, product

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.trees.events import HouseEvent

MANY = [
    GateKind.OR,
    GateKind.AND,
    GateKind.NAND,
    GateKind.NOR,
    GateKind.XOR,
    GateKind.ATLEAST,
    GateKind.CARDINALITY,
]
TWO = [GateKind.IFF, GateKind.IMPLY, GateKind.INHIBIT]
ONE = [GateKind.NOT, GateKind.TRANSFER]


@st.composite
def trees(draw):
    """Draw a tree of every kind of gate that shares nothing, of up to seven events."""
    numbers = count()
    gates, events, houses = [], [], []

    def grow(size, depth):
        name = f"n{next(numbers)}"
        if size == 1 and (depth > 2 or draw(st.booleans())):
            if draw(st.integers(0, 9)):
                events.append(BasicEvent(name))
            else:
                houses.append(HouseEvent(name, draw(st.booleans())))
            return name
        width = size if depth > 3 else draw(st.integers(1, min(size, 4)))
        sizes = [size // width + (rank < size % width) for rank in range(width)]
        inputs = tuple(grow(part, depth + 1) for part in sizes)
        kind = draw(
            st.sampled_from(
                MANY[: 7 if width > 1 else 4]
                + (TWO if width == 2 else [])
                + (ONE if width == 1 else [])
            )
        )
        k = most = None
        if kind is GateKind.ATLEAST:
            k = draw(st.integers(1, width))
        elif kind is GateKind.CARDINALITY:
            k = draw(st.integers(0, width))
            most = draw(st.integers(k, width))
        gates.append(Gate(name, kind, inputs, k, most))
        return name

    top = grow(draw(st.integers(1, 7)), 0)
    return FaultTree(top, tuple(gates), tuple(events), tuple(houses))


def happens(tree, outcome):
    """Whether the top happens, by the words that define each kind of gate."""
    states = dict(outcome) | {house.name: house.state for house in tree.houses}
    for gate in tree.upwards:
        inputs = [states[name] for name in gate.inputs]
        number = sum(inputs)
        states[gate.name] = {
            GateKind.OR: number > 0,
            GateKind.AND: number == len(inputs),
            GateKind.INHIBIT: number == len(inputs),
            GateKind.TRANSFER: inputs[0],
            GateKind.NAND: number < len(inputs),
            GateKind.NOR: number == 0,
            GateKind.NOT: not inputs[0],
            GateKind.XOR: number % 2 == 1,
            GateKind.IFF: inputs[0] == inputs[-1],
            GateKind.IMPLY: not inputs[0] or inputs[-1],
            GateKind.ATLEAST: number >= (gate.k or 0),
            GateKind.CARDINALITY: (gate.k or 0) <= number <= (gate.most or 0),
        }[gate.kind]
    return states[tree.top]


probabilities = st.one_of(st.sampled_from([0.0, 1.0, 1e-20, 1.0 - 2.0**-53]), st.floats(1e-25, 1.0))


@settings(max_examples=20, deadline=None)
@given(tree=trees(), data=st.data())
def test_the_top_given_each_event_equals_exact_enumeration(tree, data):
    names = [event.name for event in tree.events]
    values = {name: data.draw(probabilities) for name in names}
    found = tree.conditional_tops(values)
    assert list(found) == names
    for name in names:
        for state, pair in ((True, found[name].given), (False, found[name].without)):
            exact = exact_given(tree, values, name, state)
            assert pair.p == pytest.approx(float(exact[1]), rel=1e-14, abs=0.0)
            assert pair.q == pytest.approx(float(exact[0]), rel=1e-14, abs=0.0)


def test_the_top_given_a_shared_event_counts_all_that_it_feeds():
    tree = FaultTree.of("top", {"top": ("or", ("and", "a", "b"), ("and", "a", "c"))})
    found = tree.conditional_tops({"a": 0.25, "b": 0.5, "c": 0.5})
    assert found["a"].given == (0.75, 0.25)
    assert found["a"].without == (0.0, 1.0)
    assert found["b"].given.p == 0.25
    assert found["b"].without.p == 0.125


@st.composite
def shared_trees(draw):
    """Draw gates over six events and the gates before them, which may all be shared."""
    gates = []
    for index in range(draw(st.integers(2, 6))):
        below = [*"abcdef", *(gate.name for gate in gates)]
        inputs = draw(st.lists(st.sampled_from(below), min_size=2, max_size=3, unique=True))
        kind = draw(st.sampled_from([GateKind.OR, GateKind.AND, GateKind.XOR, GateKind.NAND]))
        gates.append(Gate(f"g{index}", kind, tuple(inputs)))
    wanted, below = [gates[-1].name], set()
    by_name = {gate.name: gate for gate in gates}
    for name in wanted:
        below.add(name)
        wanted += [each for each in by_name[name].inputs if each in by_name and each not in below]
    kept = tuple(gate for gate in gates if gate.name in below)
    used = sorted({name for gate in kept for name in gate.inputs if name not in by_name})
    return FaultTree(gates[-1].name, kept, tuple(map(BasicEvent, used)))


def exact_given(tree, values, name, state):
    """P(not top) and P(top), given that an event happens or does not, in rationals."""
    exact = [Fraction(0), Fraction(0)]
    others = [event.name for event in tree.events if event.name != name]
    for outcome in product((False, True), repeat=len(others)):
        weight = Fraction(1)
        for other, happened in zip(others, outcome, strict=True):
            weight *= Fraction(values[other]) if happened else 1 - Fraction(values[other])
        exact[happens(tree, {**dict(zip(others, outcome, strict=True)), name: state})] += weight
    return exact


@given(tree=shared_trees(), data=st.data())
def test_the_top_of_shared_events_given_each_equals_exact_enumeration(tree, data):
    values = {event.name: data.draw(probabilities) for event in tree.events}
    for name, pairs in tree.conditional_tops(values).items():
        for state, pair in ((True, pairs.given), (False, pairs.without)):
            q, p = exact_given(tree, values, name, state)
            assert pair.p == pytest.approx(float(p), rel=1e-14, abs=0.0)
            assert pair.q == pytest.approx(float(q), rel=1e-14, abs=0.0)


@pytest.mark.parametrize("kind", [GateKind.OR, GateKind.AND, GateKind.NOR])
@pytest.mark.parametrize("p", [1e-12, 1e-4, 0.75, 1.0])
def test_of_many_inputs_the_rounding_does_not_add_up(kind, p):
    size = 5000
    values = [p, 0.0, 0.5] + [p] * (size - 3)
    names = [f"e{index}" for index in range(size)]
    tree = FaultTree("top", (Gate("top", kind, tuple(names)),), tuple(map(BasicEvent, names)))
    found = tree.conditional_tops(dict(zip(names, values, strict=True)))["e1"]
    with mpmath.workdps(60):
        any_other = 1 - (1 - mpmath.mpf(p)) ** (size - 2) / 2
        all_others = mpmath.mpf(p) ** (size - 2) / 2
        expected = {
            GateKind.OR: (1, any_other),
            GateKind.AND: (all_others, 0),
            GateKind.NOR: (0, 1 - any_other),
        }[kind]
        assert found.given.p == pytest.approx(float(expected[0]), rel=1e-13)
        assert found.without.p == pytest.approx(float(expected[1]), rel=1e-13)


def test_importance_of_a_wide_tree_takes_one_pass():
    # One pass for each of them would take hours.
    events = {f"e{index}": 1e-9 for index in range(10_000)}
    tree = FaultTree.of(
        "top", {"top": ("or", ("and", *list(events)[:2]), *list(events)[2:])}, events
    )
    table = tree.solve().importance()
    assert len(table) == 10_000
    assert table["e0"].birnbaum == pytest.approx(1e-9, rel=1e-4)
    assert table["e5"].risk_achievement_worth == pytest.approx(
        1 / tree.solve().probability, rel=1e-12
    )
