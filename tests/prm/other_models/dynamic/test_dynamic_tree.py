"""Dynamic gates against formulas on paper, mpmath and static trees of the same meaning."""

import math
import re
from dataclasses import replace

import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.dynamic import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicGroup,
    DynamicKind,
    DynamicTree,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.other_models.formats import galileo
from tracerisk.prm.trees.failure_models import Constant, Erlang, Exponential, PerDemand, Weibull
from tracerisk.prm.trees.gates import Gate, GateKind
from tracerisk.prm.trees.spares import Spares, spare_group_failure

mpmath = pytest.importorskip("mpmath", reason="mpmath gives the exact figures")

PAND, POR, SPARE = DynamicKind.PAND, DynamicKind.POR, DynamicKind.SPARE
OR, AND = GateKind.OR, GateKind.AND
SEQUENCE, EXCLUSION = RestrictionKind.SEQUENCE, RestrictionKind.EXCLUSION


def event(name, rate, dormancy=1.0):
    return DynamicEvent(name, Exponential(rate), dormancy)


def tree(gates, events, *ties, top="top"):
    return DynamicTree(
        top,
        tuple(gates),
        tuple(events),
        tuple(tie for tie in ties if isinstance(tie, Dependency)),
        tuple(tie for tie in ties if isinstance(tie, Restriction)),
    )


def phases(*rates, time=1):
    """The chance that phases of these rates, all different, end in turn within a time."""
    with mpmath.workdps(200):
        rates = [mpmath.mpf(rate) for rate in rates]
        total = mpmath.mpf(1)
        for i, rate in enumerate(rates):
            others = mpmath.mpf(1)
            for j, other in enumerate(rates):
                others *= other / (other - rate) if i != j else 1
            total -= others * mpmath.exp(-rate * time)
        return float(total), float(1 - total)


@pytest.mark.parametrize("rate", [1e-20, 1e-9, 1e-3, 1.0, 30.0])
@pytest.mark.parametrize("units", [2, 3, 6])
def test_cold_spares_follow_erlangs_law(rate, units):
    names = tuple(f"u{number}" for number in range(units))
    found = tree(
        [DynamicGate("top", SPARE, names)], [event(name, rate, 0.0) for name in names]
    ).probability(1.0)
    expected = Erlang(rate, units).probability(1.0)
    assert found == (pytest.approx(expected.p, rel=2e-13), pytest.approx(expected.q, rel=2e-13))


@pytest.mark.parametrize("scale", [1e-15, 1e-4, 1.0])
def test_a_warm_spare_fails_while_it_waits(scale):
    # In use at rate 3, waiting at 0.3 * 2: the second phase is that of the one that is left.
    made = tree(
        [DynamicGate("top", SPARE, ("a", "b"))], [event("a", 3 * scale), event("b", 2 * scale, 0.3)]
    )
    first, waiting, second = 3 * scale, 0.6 * scale, 2 * scale
    leaving = first + waiting
    taken = phases(leaving, second)[0] * first / leaving
    lost = phases(leaving, first)[0] * waiting / leaving
    assert made.probability(1.0).p == pytest.approx(taken + lost, rel=1e-13)


@pytest.mark.parametrize("p", [1e-9, 1e-3, 0.5])
@pytest.mark.parametrize(
    ("units", "required", "dormancy", "switch"),
    [(3, 2, 0.3, 0.1), (5, 3, 0.2, 0.01), (4, 1, 0.0, 0.0), (4, 2, 1.0, 0.5), (2, 1, 0.5, 1.0)],
)
def test_a_pool_of_like_spares_is_a_spare_group(p, units, required, dormancy, switch):
    rate = -math.log1p(-p)
    pool = tuple(f"spare{number}" for number in range(units - required))
    users = tuple(f"gate{number}" for number in range(required))
    made = tree(
        [
            Gate("top", OR, users),
            *(
                DynamicGate(gate, SPARE, (f"unit{number}", *pool), switch=switch)
                for number, gate in enumerate(users)
            ),
        ],
        [event(f"unit{number}", rate) for number in range(required)]
        + [event(name, rate, dormancy) for name in pool],
    )
    expected = spare_group_failure(
        p, units=units, required=required, spares=Spares(dormancy, switch)
    ).p
    assert made.probability(1.0).p == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("scale", [1e-18, 1e-3, 2.0])
def test_pand_happens_in_its_order_only(scale):
    made = tree([DynamicGate("top", PAND, ("a", "b"))], [event("a", scale), event("b", 2 * scale)])
    # a is the first with 1/3, and b follows.
    assert made.probability(1.0).p == pytest.approx(phases(3 * scale, 2 * scale)[0] / 3, rel=1e-13)


def test_por_happens_when_its_first_input_is_the_first():
    made = tree([DynamicGate("top", POR, ("a", "b"))], [event("a", 1e-9), event("b", 2e-9)])
    assert made.probability(1.0).p == pytest.approx(-math.expm1(-3e-9) / 3, rel=1e-14)


@pytest.mark.parametrize(("inclusive", "expected"), [(True, -math.expm1(-1.0)), (False, 0.0)])
@pytest.mark.parametrize("kind", [PAND, POR])
def test_failures_at_one_instant_are_in_order_for_inclusive_gates(kind, inclusive, expected):
    made = tree(
        [DynamicGate("top", kind, ("a", "b"), inclusive)],
        [event("a", 0.0), event("b", 0.0), event("power", 1.0)],
        Dependency("lost", "power", ("a", "b")),
    )
    assert made.probability(1.0).p == pytest.approx(expected, rel=1e-14)


def test_a_dependent_fails_after_its_trigger():
    ordered = [event("a", 0.0), event("b", 1.0)]
    before = tree([DynamicGate("top", PAND, ("a", "b"))], ordered, Dependency("d", "b", ("a",)))
    after = tree([DynamicGate("top", PAND, ("b", "a"))], ordered, Dependency("d", "b", ("a",)))
    assert before.probability(1.0).p == 0.0
    assert after.probability(1.0).p == pytest.approx(-math.expm1(-1.0), rel=1e-14)


@pytest.mark.parametrize("probability", [1.0, 0.25])
@pytest.mark.parametrize("rate", [1e-12, 0.1, 3.0])
def test_dependency_is_a_cause_of_all_its_events(rate, probability):
    made = tree(
        [Gate("top", AND, ("a", "b"))],
        [event("a", rate), event("b", 2 * rate), event("power", rate / 4)],
        Dependency("lost", "power", ("a", "b"), probability),
    )
    a, b, hit = (
        -math.expm1(-rate),
        -math.expm1(-2 * rate),
        -math.expm1(-rate / 4) * probability,
    )
    assert made.probability(1.0).p == pytest.approx(hit + (1 - hit) * a * b, rel=1e-12)


def test_a_sequence_gives_each_its_turn():
    made = tree(
        [Gate("top", AND, ("a", "b", "c"))],
        [event("a", 1e-6), event("b", 2e-6), event("c", 4e-6)],
        Restriction("order", SEQUENCE, ("a", "b", "c")),
    )
    assert made.probability(1.0).p == pytest.approx(phases(1e-6, 2e-6, 4e-6)[0], rel=1e-13)


def test_a_sequence_holds_where_its_inputs_make_no_difference_any_more():
    made = tree(
        [Gate("top", AND, ("late", "other", "g")), Gate("g", OR, ("early", "x"))],
        [event("early", 2.0), event("late", 0.5), event("other", 0.25), event("x", 0.125)],
        Restriction("order", SEQUENCE, ("early", "late")),
    )
    expected = phases(2.0, 0.5)[0] * -math.expm1(-0.25)
    assert made.probability(1.0).p == pytest.approx(expected, rel=1e-13)


def test_an_exclusion_lets_only_one_happen():
    made = tree(
        [Gate("top", OR, ("both", "a")), Gate("both", AND, ("a", "b"))],
        [event("a", 1.0), event("b", 3.0)],
        Restriction("one", EXCLUSION, ("a", "b")),
    )
    assert made.probability(1.0).p == pytest.approx(-math.expm1(-4.0) / 4, rel=1e-13)


def test_a_dependency_that_is_ruled_out_waits_until_it_may():
    made = tree(
        [Gate("top", OR, ("late",))],
        [event("early", 1.0), event("late", 0.0), event("trigger", 2.0)],
        Dependency("pull", "trigger", ("late",)),
        Restriction("order", SEQUENCE, ("early", "late")),
    )
    # Both the trigger and the early one have to happen, in either order.
    expected = -math.expm1(-1.0) * -math.expm1(-2.0)
    assert made.probability(1.0).p == pytest.approx(expected, rel=1e-13)


def test_a_shared_spare_serves_the_first_that_needs_it():
    made = tree(
        [
            Gate("top", AND, ("g", "h")),
            DynamicGate("g", SPARE, ("a", "s")),
            DynamicGate("h", SPARE, ("b", "s")),
        ],
        [event("a", 1e-5), event("b", 1e-5), event("s", 1e-5, 0.0)],
    )
    # Two of the three units that are ever in use at a time, until all three are gone.
    with mpmath.workdps(80):
        generator = mpmath.matrix(4, 4)
        for state, leaving in enumerate((2e-5, 2e-5, 1e-5)):
            generator[state, state], generator[state, state + 1] = -leaving, leaving
        expected = float(mpmath.expm(generator)[0, 3])
    assert made.probability(1.0).p == pytest.approx(expected, rel=1e-12)


def test_a_spare_gate_takes_a_spare_even_where_its_own_failure_makes_no_difference():
    """Where `d` has failed, `g` still takes `s` when `a` fails, and leaves `h` without it."""
    made = tree(
        [
            Gate("top", AND, ("e", "h")),
            Gate("e", OR, ("d", "g")),
            DynamicGate("g", SPARE, ("a", "s")),
            DynamicGate("h", SPARE, ("b", "s")),
        ],
        [event("a", 2.0), event("b", 3.0), event("s", 5.0, 0.5), event("d", 7.0)],
    )
    # Storm 2.0 gives this figure.
    assert made.probability(1.0).p == pytest.approx(0.9426720758616328, rel=1e-12)


def test_a_spare_may_be_a_part_with_spares_of_its_own():
    made = tree(
        [
            DynamicGate("top", SPARE, ("a", "part")),
            DynamicGate("part", SPARE, ("b", "c")),
        ],
        [event("a", 1e-4), event("b", 2e-4, 0.0), event("c", 4e-4, 0.0)],
    )
    assert made.probability(1.0).p == pytest.approx(phases(1e-4, 2e-4, 4e-4)[0], rel=1e-13)


def test_a_spare_may_be_failed_from_the_start():
    made = tree(
        [DynamicGate("top", SPARE, ("a", "b"))],
        [event("a", 1e-6), DynamicEvent("b", Constant(0.01), 0.0)],
    )
    assert made.probability(1.0).p == pytest.approx(0.01 * -math.expm1(-1e-6), rel=1e-12)
    demanded = tree(
        [DynamicGate("top", PAND, ("a", "b"))],
        [DynamicEvent("a", PerDemand(1e-3, 2)), event("b", 1e-6)],
    )
    start = PerDemand(1e-3, 2).probability(1.0).p
    assert demanded.probability(1.0).p == pytest.approx(start * -math.expm1(-1e-6), rel=1e-12)


def test_phases_of_a_spare_are_counted():
    made = tree(
        [DynamicGate("top", SPARE, ("a", "b"))],
        [DynamicEvent("a", Erlang(1e-3, 2)), DynamicEvent("b", Erlang(1e-3, 3), 0.0)],
    )
    assert made.probability(1.0).p == pytest.approx(Erlang(1e-3, 5).probability(1.0).p, rel=1e-12)


def test_many_events_in_the_mission_are_survived_with_all_digits():
    made = tree(
        [DynamicGate("top", SPARE, ("a", "b"))], [event("a", 500.0), event("b", 400.0, 0.0)]
    )
    p, q = phases(500, 400)
    assert made.probability(1.0).p == pytest.approx(p, rel=1e-12)
    assert made.probability(1.0).q == pytest.approx(q, rel=1e-10)


def test_a_chain_of_a_thousand_states_keeps_its_digits():
    rate, names = 1e-3, tuple(f"u{number}" for number in range(10))
    made = tree(
        [Gate("top", AND, names)],
        [event(name, rate * (number + 1)) for number, name in enumerate(names)]
        + [event("power", rate)],
        Dependency("lost", "power", names[:2], 0.25),
    )
    group = DynamicGroup(made)
    assert group.chain.states > 1000
    hit = 0.25 * -math.expm1(-rate)
    a, b, *others = (-math.expm1(-rate * (number + 1)) for number in range(10))
    expected = (hit + (1 - hit) * a * b) * math.prod(others)
    assert group.probability(1.0).p == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("phases", [1, 2])
def test_only_how_many_of_like_units_failed_is_counted(phases):
    names = tuple(f"u{number}" for number in range(30))
    made = tree(
        [Gate("top", GateKind.ATLEAST, names, 28)],
        [DynamicEvent(name, Erlang(0.5, phases)) for name in names] + [event("power", 1e-3)],
        Dependency("lost", "power", names, 0.5),
    )
    group = DynamicGroup(made)
    assert group.chain.states < 2500
    unit = Erlang(0.5, phases).probability(1.0)
    hit = -math.expm1(-1e-3) / 2
    rest = math.fsum(math.comb(30, k) * unit.p**k * unit.q ** (30 - k) for k in range(28, 31))
    assert group.probability(1.0).p == pytest.approx(hit + (1 - hit) * rest, rel=1e-12)


def test_only_what_is_dynamic_goes_to_a_markov_model():
    made = tree(
        [
            Gate("top", OR, ("left", "right", "alone")),
            Gate("left", AND, ("pair", "x")),
            DynamicGate("pair", SPARE, ("a", "b")),
            Gate("right", AND, ("y", "z")),
        ],
        [event(name, 1e-3) for name in ("a", "b", "x", "y", "z", "alone", "power")],
        Dependency("lost", "power", ("y", "z")),
    )
    static = made.static_tree()
    assert [gate.name for gate in static.gates] == ["top", "left"]
    assert [one.name for one in static.events] == ["x", "alone", "pair", "right"]
    pair, right = (one.model for one in static.events[2:])
    assert isinstance(pair, DynamicGroup)
    assert {one.name for one in pair.tree.events} == {"a", "b"}
    assert {one.name for one in right.tree.events} == {"y", "z", "power"}


def test_a_group_takes_in_what_it_shares():
    made = tree(
        [
            Gate("top", OR, ("both", "alone")),
            Gate("both", AND, ("pair", "other")),
            DynamicGate("pair", PAND, ("a", "b")),
            Gate("other", OR, ("b", "c")),
        ],
        [event(name, 1e-3) for name in ("a", "b", "c", "alone")],
    )
    static = made.static_tree()
    assert [one.name for one in static.events] == ["alone", "both"]
    assert static.probability(static.values_at(10.0)).p == pytest.approx(
        made.probability(10.0).p, rel=1e-15
    )


def test_a_group_takes_in_what_a_trigger_beside_the_tree_shares():
    made = tree(
        [
            Gate("top", OR, ("pair", "other")),
            DynamicGate("pair", PAND, ("a", "b")),
            Gate("other", OR, ("c", "d")),
            Gate("cause", OR, ("c", "e")),
        ],
        [event(name, 1e-3) for name in "abcde"],
        Dependency("lost", "cause", ("a",)),
    )
    assert [one.name for one in made.static_tree().events] == ["top"]


def test_a_tree_of_static_gates_is_left_as_it_is():
    made = tree([Gate("top", AND, ("a", "b"))], [event("a", 1e-9), event("b", 1e-9)])
    static = made.static_tree()
    assert (static.gates, len(static.events)) == (made.gates, 2)
    assert made.probability(1.0).p == pytest.approx(1e-18, rel=1e-8)


def test_too_many_states_are_refused():
    names = tuple("u" * number for number in range(1, 13))
    made = DynamicTree(
        "top",
        (DynamicGate("top", PAND, ("x", "y")), Gate("x", AND, names)),
        tuple(event(name, 1e-3 * len(name)) for name in (*names, "y")),
        state_limit=100,
    )
    with pytest.raises(TooLargeError, match="below 'top', with 13 events, has more than 100 st"):
        made.probability(1.0)


@pytest.mark.parametrize(
    ("gate", "model", "message"),
    [
        (
            DynamicGate("top", SPARE, tuple(f"u{number}" for number in range(251))),
            Exponential(1e-3),
            "gate 'top': 251 inputs of a spare gate; allowed: 250",
        ),
        (
            DynamicGate("top", SPARE, ("u0", "u1")),
            Erlang(1e-3, 251),
            "event 'u0': 251 phases in the group of a dynamic gate; allowed: 250",
        ),
    ],
)
def test_too_many_inputs_or_phases_are_refused(gate, model, message):
    made = tree([gate], [DynamicEvent(name, model) for name in gate.inputs])
    with pytest.raises(TooLargeError, match=re.escape(message)):
        made.probability(1.0)


def test_too_many_events_failed_from_the_start_are_refused():
    names = tuple(f"u{number}" for number in range(17))
    made = tree(
        [DynamicGate("top", PAND, names)], [DynamicEvent(name, Constant(0.5)) for name in names]
    )
    with pytest.raises(TooLargeError, match="17 events that may be failed from the start; all"):
        made.probability(1.0)


def test_static_gates_of_a_group_may_have_any_number_of_inputs():
    names = tuple(f"u{number}" for number in range(300))
    made = tree(
        [DynamicGate("top", PAND, ("any", "b")), Gate("any", OR, names)],
        [event(name, 1e-3) for name in names] + [event("b", 0.1)],
    )
    first = 0.3 / 0.4
    assert made.probability(1.0).p == pytest.approx(phases(0.4, 0.1)[0] * first, rel=1e-12)


def test_fast_events_beside_rare_ones_are_no_trouble():
    made = tree([DynamicGate("top", PAND, ("a", "b"))], [event("a", 1e12), event("b", 1e-9)])
    assert made.probability(1.0).p == pytest.approx(1e-9, rel=1e-8)


def with_ties(*ties):
    return lambda: tree([Gate("top", AND, ("a", "b"))], [event("a", 1.0), event("b", 1.0)], *ties)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: DynamicGate("g", SPARE, ()),
            "gate 'g': spare needs at least one input",
        ),
        (lambda: DynamicGate("g", PAND, ("a", "a")), "gate 'g': duplicate input"),
        (
            lambda: DynamicGate("g", PAND, ("a",), switch=0.1),
            "gate 'g': switch is for spare gates only",
        ),
        (
            lambda: DynamicGate("g", SPARE, ("a",), inclusive=False),
            "gate 'g': inclusive is for pand and por",
        ),
        (lambda: event("a", 1.0, 2.0), "event 'a': dormancy is 2.0; allowed: 0 to 1"),
        (lambda: Dependency("d", "a", ()), "dependency 'd': it needs at least one dependent"),
        (lambda: Dependency("d", "a", ("b",), 0.0), "dependency 'd': probability is 0.0"),
        (lambda: Restriction("r", SEQUENCE, ("a",)), "restriction 'r': seq needs two inputs"),
        (with_ties(Dependency("top", "a", ("b",))), "'top' names two gates, events,"),
        (
            with_ties(Dependency("d", "c", ("b",))),
            "'d': input 'c' is not a gate or event; allowed: a, b, top",
        ),
        (with_ties(Dependency("d", "a", ("top",))), "dependency 'd': dependent 'top' is a gate"),
        (
            lambda: tree([Gate("top", OR, ("a",))], [event("a", 1.0), event("b", 1.0)]),
            "not below the top 'top': b; connect or remove them",
        ),
        (
            lambda: tree([Gate("top", OR, ("g",)), Gate("g", OR, ("top",))], []),
            "gate 'top' depends on itself; break the cycle",
        ),
        (lambda: tree([], [event("a", 1.0)]), "top 'top' is not a gate or event; allowed: a"),
    ],
)
def test_trees_that_do_not_hold_together_are_refused(make, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        make()


@pytest.mark.parametrize(
    ("gates", "events", "message"),
    [
        (
            [DynamicGate("top", PAND, ("n", "b")), Gate("n", GateKind.NOT, ("a",))],
            [event("a", 1.0), event("b", 1.0)],
            "gate 'n': not is not allowed in the group of a dynamic gate; allowed: or, and",
        ),
        (
            [DynamicGate("top", PAND, ("a", "b"))],
            [event("a", 1.0), DynamicEvent("b", Weibull(1.0, 2.0))],
            "event 'b': Weibull is not allowed in the group of a dynamic gate",
        ),
        (
            [
                DynamicGate("top", SPARE, ("d", "y")),
                Gate("y", OR, ("g", "m")),
                DynamicGate("g", SPARE, ("a", "b")),
                Gate("m", OR, ("b", "c")),
            ],
            [event(name, 1.0) for name in "abcd"],
            "'b' is a spare of 'g' and an input of 'm', which may itself",
        ),
        (
            [
                Gate("top", OR, ("g", "h")),
                DynamicGate("g", SPARE, ("a", "b")),
                DynamicGate("h", SPARE, ("a", "c")),
            ],
            [event(name, 1.0) for name in "abc"],
            "'a' is in use from the start by two spare gates, 'g' and 'h'",
        ),
        (
            [
                DynamicGate("top", SPARE, ("g", "h")),
                Gate("g", OR, ("a", "b")),
                Gate("h", OR, ("b", "c")),
            ],
            [event(name, 1.0) for name in "abc"],
            "'b' is part of the spare 'h' and an input of 'g' outside it",
        ),
    ],
)
def test_groups_without_a_meaning_are_refused(gates, events, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        tree(gates, events).probability(1.0)


@pytest.mark.parametrize("p", [1.0, 0.5])
def test_what_is_failed_from_the_start_and_ruled_out_waits(p):
    order = Restriction("order", SEQUENCE, ("a", "b"))
    made = tree(
        [Gate("top", AND, ("a", "b"))],
        [event("a", 1e-6), DynamicEvent("b", Constant(p))],
        order,
    )
    assert made.probability(1.0).p == pytest.approx(p * -math.expm1(-1e-6), rel=1e-12)
    # Whichever is named first: what has to be first is.
    both = tree(
        [Gate("top", AND, ("a", "b"))],
        [DynamicEvent("b", Constant(0.4)), DynamicEvent("a", Constant(0.2))],
        order,
    )
    assert both.probability(1.0).p == pytest.approx(0.08, rel=1e-14)


@pytest.mark.parametrize("depth", [30, 300])
def test_ways_between_states_are_bounded_as_the_states_are(depth):
    # Few states of many elements, each left in many ways: all would take minutes.
    text = "".join(f'"T{n}" pand "T{n + 1}" "A{n}"; "A{n}" lambda=1;' for n in range(depth))
    made = galileo.loads(f'toplevel "T0"; {text} "T{depth}" lambda=1;', "t.dft")
    if depth == 30:
        assert 0.0 < made.probability(1.0).p < 1e-30
        made = replace(made, state_limit=40)
    else:
        made = replace(made, state_limit=1_000)
    with pytest.raises(TooLargeError, match=r"has more than \d+ transitions; split"):
        made.probability(1.0)
