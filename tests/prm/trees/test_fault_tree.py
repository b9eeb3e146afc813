from fractions import Fraction
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.numbers.probability import Probability, at_least

OR, AND, ATLEAST = GateKind.OR, GateKind.AND, GateKind.ATLEAST


def relative_error(found: float, expected: Fraction) -> float:
    if expected == 0:
        return abs(found)
    return float(abs(Fraction(found) / expected - 1))


def flat(kind, *parameters, k=None):
    """Return a tree of one gate over events e1, e2... of the given parameters."""
    events = tuple(BasicEvent(f"e{i}", p) for i, p in enumerate(parameters, 1))
    return FaultTree("top", (Gate("top", kind, tuple(e.name for e in events), k),), events)


@st.composite
def trees(draw):
    """Draw an independent tree of up to seven events over three shared parameters."""
    numbers = count()
    gates, events = [], []
    budget = draw(st.integers(1, 7))

    def grow(size: int, depth: int) -> str:
        name = f"n{next(numbers)}"
        if size == 1 and (depth > 2 or draw(st.booleans())):
            events.append(BasicEvent(name, draw(st.sampled_from(["a", "b", "c"]))))
            return name
        parts = []
        left = size
        while left:
            part = draw(st.integers(1, left)) if depth < 3 else 1
            parts.append(part)
            left -= part
        inputs = tuple(grow(part, depth + 1) for part in parts)
        kind = draw(st.sampled_from([OR, AND, ATLEAST]))
        k = draw(st.integers(1, len(inputs))) if kind is ATLEAST else None
        gates.append(Gate(name, kind, inputs, k))
        return name

    top = grow(budget, 0)
    return FaultTree(top, tuple(gates), tuple(events))


probabilities = st.one_of(
    st.sampled_from([0.0, 1.0, 1e-20, 1e-28, 0.5, 1.0 - 2.0**-53]),
    st.floats(1e-30, 1.0),
)
values = st.fixed_dictionaries(dict.fromkeys("abc", probabilities))


@given(tree=trees(), values=values)
def test_probability_and_its_complement_equal_exact_enumeration(exact, tree, values):
    expected = exact.top(tree, {name: Fraction(p) for name, p in values.items()})
    p, q = tree.probability(values)
    # 1-p of an input is rounded once, so a complement may be off by half a unit per event.
    assert relative_error(p, expected) < 1e-14
    assert relative_error(q, 1 - expected) < 1e-14


@given(tree=trees(), values=values)
def test_drop_without_a_parameter_equals_the_exact_difference(exact, tree, values):
    rational = {name: Fraction(p) for name, p in values.items()}
    expected = exact.top(tree, rational) - exact.top(tree, {**rational, "a": Fraction(0)})
    assert relative_error(tree.drop_without("a", values), expected) < 1e-14


@given(tree=trees(), values=values)
def test_sensitivity_of_an_event_equals_the_exact_derivative(exact, tree, values):
    # The top is linear in each event, so the derivative is top(1) - top(0).
    target = tree.events[0]
    alone = FaultTree(tree.top, tree.gates, (BasicEvent(target.name, "its own"), *tree.events[1:]))
    rational = {name: Fraction(p) for name, p in values.items()}
    high = exact.top(alone, {**rational, "its own": Fraction(1)})
    low = exact.top(alone, {**rational, "its own": Fraction(0)})
    assert relative_error(tree.sensitivities(values)[target.name], high - low) < 1e-14


def test_or_of_two_is_the_sum_less_the_product():
    p, q = flat(OR, "a", "b").probability({"a": 0.25, "b": 0.5})
    assert (p, q) == (0.625, 0.375)


def test_and_of_a_redundant_pair_is_the_square():
    p, q = flat(AND, "a", "a").probability({"a": 1e-20})
    assert p == pytest.approx(1e-40, rel=1e-15)
    assert q == 1.0


def test_two_out_of_three_is_three_squares_less_two_cubes():
    p, q = flat(ATLEAST, "a", "a", "a", k=2).probability({"a": 0.5})
    assert (p, q) == (0.5, 0.5)
    small, _ = flat(ATLEAST, "a", "a", "a", k=2).probability({"a": 1e-12})
    assert small == pytest.approx(3e-24 - 2e-36, rel=1e-15)


def test_a_survival_of_1e_20_is_not_lost_beside_a_failure_of_nearly_one():
    # Two events that each survive with 2^-52: together they survive with 2^-104.
    p, q = flat(OR, "a", "a").probability({"a": 1.0 - 2.0**-52})
    assert p == 1.0
    assert q == 2.0**-104


def test_an_or_of_nothing_never_happens():
    assert flat(OR).probability({}) == Probability(0.0, 1.0)


def test_at_least_none_always_happens_and_more_than_all_never_does():
    pair = Probability.of(0.25)
    assert at_least(0, [pair]) == (1.0, 0.0)
    assert at_least(2, [pair]) == (0.0, 1.0)


def test_an_event_may_be_the_top_itself():
    tree = FaultTree("motor", (), (BasicEvent("motor", "theta"),))
    assert tree.probability({"theta": 0.125}) == (0.125, 0.875)
    assert tree.sensitivities({"theta": 0.125}) == {"motor": 1.0}


def test_a_tree_of_five_thousand_levels_is_solved():
    depth = 5000
    gates = tuple(Gate(f"g{i}", OR, (f"g{i + 1}", f"e{i}")) for i in range(depth))
    gates += (Gate(f"g{depth}", OR, ()),)
    events = tuple(BasicEvent(f"e{i}", "a") for i in range(depth))
    p, _ = FaultTree("g0", gates, events).probability({"a": 1e-20})
    assert p == pytest.approx(depth * 1e-20, rel=1e-12)


def test_parameters_are_listed_once_in_the_order_of_the_events():
    assert flat(OR, "b", "a", "b").parameters == ("b", "a")


def test_a_shared_event_is_named_with_its_gates_and_counted_once():
    gates = (
        Gate("top", OR, ("left", "right")),
        Gate("left", AND, ("pump", "x")),
        Gate("right", AND, ("pump", "y")),
    )
    tree = FaultTree("top", gates, tuple(BasicEvent(n, n) for n in ("pump", "x", "y")))
    assert tree.shared == {"pump": ("left", "right")}
    # The pump, and one of x and y.
    p, q = tree.probability({"pump": 0.5, "x": 0.25, "y": 0.5})
    assert (p, q) == (0.3125, 0.6875)


def test_an_event_twice_under_one_gate_counts_once():
    tree = FaultTree("top", (Gate("top", AND, ("e", "e")),), (BasicEvent("e", "a"),))
    assert tree.probability({"a": 0.5}) == (0.5, 0.5)
    assert tree.sensitivities({"a": 0.5}) == {"e": 1.0}


@pytest.mark.parametrize(
    ("top", "gates", "events", "message"),
    [
        ("top", [("top", OR, ("a", "b"))], ["a", "a", "b"], "'a' names two gates or events"),
        (
            "tip",
            [("top", OR, ("a",))],
            ["a"],
            "top 'tip' is not a gate or event; allowed: a, top",
        ),
        ("top", [("top", OR, ("b",))], ["a"], "gate 'top': input 'b' is not a gate or event"),
        ("top", [("top", AND, ())], [], "gate 'top': and needs at least one input"),
        (
            "top",
            [("top", OR, ("a",), 1)],
            ["a"],
            "gate 'top': k is for atleast and cardinality only",
        ),
        ("top", [("top", ATLEAST, ("a",))], ["a"], "gate 'top': k is None; allowed: 1 to 1"),
        ("top", [("top", ATLEAST, ("a",), 2)], ["a"], "gate 'top': k is 2; allowed: 1 to 1"),
        ("top", [("top", OR, ("a",))], ["a", "b"], "not below the top 'top': b"),
        (
            "top",
            [("top", OR, ("mid",)), ("mid", OR, ("top", "a"))],
            ["a"],
            "gate 'top' depends on itself;",
        ),
    ],
)
def test_a_malformed_tree_is_refused_with_its_element(top, gates, events, message):
    with pytest.raises(ModelError, match=message.replace("(", r"\(")):
        FaultTree(
            top, tuple(Gate(*gate) for gate in gates), tuple(BasicEvent(e, e) for e in events)
        )


def test_a_parameter_without_value_is_refused_with_the_names_that_have_one():
    with pytest.raises(ModelError, match="event 'e1': parameter 'a' has no value; allowed: b"):
        flat(OR, "a").probability({"b": 0.5})


@pytest.mark.parametrize("value", [-1e-9, 1.5, float("nan"), float("inf")])
def test_a_value_outside_zero_to_one_is_refused(value):
    with pytest.raises(ModelError, match=r"event 'e1': probability .* is outside \[0, 1\]"):
        flat(OR, "a").probability({"a": value})
