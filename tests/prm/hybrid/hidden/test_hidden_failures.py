"""Failures of redundant units that stay hidden until the mission ends."""

import math
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm import (
    BasicEvent,
    FaultTree,
    FunctionState,
    Gate,
    GateKind,
    HybridModel,
    NextStep,
    Parameter,
    build_model,
    solve,
)
from tracerisk.prm.hybrid.hidden.hidden_states import hidden_states
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.prm.numbers.binomial import failure_counts
from tracerisk.prm.other_models.formats.expanded_chain import expanded_chain

RENEWED = "true, detected each_visit"


def close(expected):
    return pytest.approx(float(expected), rel=1e-12, abs=0.0)


@pytest.fixture
def straight(block, component):
    """Make a mission of functions in a row, each with the same components."""

    def make(visits, *parts):
        blocks = [block(f"f{i}", i, [component(*p) for p in parts]) for i in range(1, visits + 1)]
        return build_model(blocks, name="m")

    return make


def failure(model):
    return solve(model).mission.failure_probability


def test_a_pair_over_fifty_visits_is_fifty_times_the_pair_renewed_at_each(straight):
    for p in (1e-6, 6.7e-8, 1e-20):
        latent, renewed = (
            straight(50, ("pair", p, 2, "true")),
            straight(50, ("pair", p, 2, RENEWED)),
        )
        # (np)^2 against n p^2, to first order.
        assert failure(latent) / failure(renewed) == pytest.approx(50, rel=1e-4)
        alive = (1 - Fraction(p)) ** 50
        assert failure(latent) == close((1 - alive) ** 2)


@pytest.mark.parametrize("required", [1, 2, 3])
def test_a_group_over_a_mission_fails_as_its_units_do_over_all_of_it(straight, required):
    p = Fraction(1, 8)
    model = straight(5, ("cell", float(p), 4, f"required {required}"))
    failed = 1 - (1 - p) ** 5
    expected = sum(
        math.comb(4, k) * failed**k * (1 - failed) ** (4 - k) for k in range(5 - required, 5)
    )
    assert failure(model) == close(expected)


def test_a_unit_that_failed_unseen_in_one_function_is_missing_in_the_next(block, component):
    # Either of two suffices to lift, both are needed to hold.
    p, q = Fraction(1, 4), Fraction(1, 8)
    model = build_model(
        [
            block("lift", 1, (component("motor", 0.25, 2, "true"),)),
            block("hold", 2, (component("motor", 0.125, 2, "false"),)),
        ],
        name="m",
    )
    assessment = solve(model)
    assert assessment.mission.failure_probability == close(1 - ((1 - p) * (1 - q)) ** 2)
    lift, hold = assessment.states
    assert lift.top_event == close(p**2)
    assert hold.top_event == close(1 - ((1 - p) * (1 - q)) ** 2 / (1 - p**2))
    # Exactly so many visits: the stricter function decides.
    assert assessment.mission.visits_as_run == close(1 - ((1 - p) * (1 - q)) ** 2)


def test_a_mission_of_fixed_cycles_carries_hidden_failures_from_one_to_the_next(block, component):
    p = Fraction(1, 16)
    part = component("power", float(p), 2, "true")

    def mission(weight):
        after = {"a": weight, "done": 1 - weight}
        return solve(build_model([block("a", 1, (part,), after=after)], name="m")).mission

    # The squaring of many cycles and the walk through few give the same answer on paper.
    for cycles in (2, 3, 10, 200):
        expected = (1 - (1 - p) ** cycles) ** 2
        found = mission(Fraction(cycles - 1, cycles))
        assert found.expected_cycles == close(cycles)
        assert found.fixed_cycles == close(expected)
        assert found.visits_as_run == close(expected)
        assert found.cycle_failure_probability == close(p**2)
    # Half way between two and three cycles, on the logarithm of survival.
    between = mission(Fraction(3, 5)).fixed_cycles
    two, three = (1 - (1 - (1 - p) ** n) ** 2 for n in (2, 3))
    assert between == close(1 - math.sqrt(two * three))


def test_the_geometric_number_of_cycles_doubles_the_share_of_a_pair(block, component):
    # Sum over n of (n p)^2 with weight (1-r) r^(n-1) is p^2 (1+r) / (1-r)^2: near twice (Np)^2.
    part = component("power", 1e-9, 2, "true")
    loop = block("a", 1, (part,), after={"a": "99/100", "done": "1/100"})
    mission = solve(build_model([loop], name="m")).mission
    assert mission.failure_probability == pytest.approx(1.99 * (100 * 1e-9) ** 2, rel=1e-4)
    assert mission.fixed_cycles == pytest.approx((100 * 1e-9) ** 2, rel=1e-4)


def pieces_of(p, shares):
    """Return the probabilities of parts of an exposure, so that the survivals multiply."""
    total = sum(shares)
    return [-math.expm1(math.log1p(-p) * share / total) for share in shares]


@given(
    pair=st.floats(1e-12, 0.3),
    motor=st.floats(1e-12, 0.3),
    required=st.integers(1, 3),
    shares=st.lists(st.integers(1, 9), min_size=2, max_size=5),
    cycles=st.integers(1, 4),
)
def test_cutting_a_function_into_pieces_leaves_the_mission_as_it_is(
    block, component, pair, motor, required, shares, cycles
):
    def mission(pieces):
        blocks = []
        for i, (a, b) in enumerate(pieces, 1):
            parts = (component("cell", a, 3, f"required {required}"), component("motor", b, 2))
            blocks.append(block(f"f{i}", i, parts))
        profile = {
            f"f{len(pieces)}": {"f1": Fraction(cycles - 1, cycles), "done": Fraction(1, cycles)}
        }
        return solve_figures(build_model(blocks, profile=profile, name="m")).mission

    whole = mission([(pair, motor)])
    cut = mission(list(zip(pieces_of(pair, shares), pieces_of(motor, shares), strict=True)))
    for reading in ("failure_probability", "fixed_cycles", "visits_as_run"):
        assert getattr(cut, reading) == pytest.approx(getattr(whole, reading), rel=1e-12)


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_random_missions_equal_the_enumeration_of_every_event(exact, small_models, data):
    model = data.draw(small_models())
    expected = exact.mission(model)
    assume(expected > 0)
    assessment = solve(model)
    mission = assessment.mission
    assert mission.failure_probability == close(expected)
    assert mission.done_probability == close(1 - expected)
    for state in assessment.states:
        assert state.absorption_probability == close(state.expected_visits * state.top_event)
    for found in assessment.components:
        without = exact.mission(model, {found.name: Fraction(0)})
        assert found.without == close(without)
        assert found.fussell_vesely == close((expected - without) / expected)
        if without == 0:
            assert found.risk_reduction_worth == math.inf
        else:
            assert found.risk_reduction_worth == close(expected / without)


@given(data=st.data())
def test_contributions_are_the_fall_of_the_top_event_without_the_component(small_models, data):
    model = data.draw(small_models(least=1e-3))
    for state in solve(model).states:
        for part in state.components:
            assert 0.0 <= part.contribution <= state.top_event * (1 + 1e-12)
    names = {parameter.name for parameter in model.parameters}
    if len(names) == 1:
        for state in solve(model).states:
            for part in state.components:
                assert part.contribution == close(state.top_event)


def test_a_hidden_failure_far_below_the_rest_keeps_its_digits(exact, block, component):
    # A pair of 6.7e-08 whose share is 1e-13 of the mission's risk, and one of 1e-20.
    blocks = [
        block(
            name,
            number,
            (
                component("pair", 6.7e-8, 2, "true"),
                component("tiny", 1e-20, 2, "true"),
                component("weak", 0.125),
            ),
            after=after,
        )
        for number, (name, after) in enumerate(
            {"a": {"b": 1}, "b": {"a": "1/2", "done": "1/2"}}.items(), 1
        )
    ]
    model = build_model(blocks, name="m")
    total = exact.mission(model)
    found = {each.name: each for each in solve(model).components}
    for name in ("pair", "tiny"):
        without = exact.mission(model, {name: Fraction(0)})
        assert found[name].fussell_vesely == close((total - without) / total)
    assert found["tiny"].fussell_vesely < 1e-38


def test_assumptions_say_what_became_of_hidden_failures(straight):
    def reported(*kinds):
        parts = [(f"p{i}", 1e-6, 2, kind) for i, kind in enumerate(kinds)]
        return [line.split(" ")[0] for line in solve(straight(2, *parts)).assumptions]

    assert reported("false") == []
    assert reported("true") == ["failed"]
    assert reported(RENEWED) == ["redundant"]
    assert reported("true", RENEWED) == ["redundant", "failed"]
    assert reported("true, spare cold") == ["failed"]
    assert reported("true, spare cold, detected each_visit") == ["groups"]


def test_a_group_that_one_function_renews_and_another_does_not_stays_failed(block, component):
    # The same two units: what is hidden in one function is not whole in the other.
    model = build_model(
        [
            block("a", 1, (component("power", 0.25, 2, "true"),)),
            block("b", 2, (component("power", 0.25, 2, RENEWED),)),
        ],
        name="m",
    )
    assert model.latent == ("power[1]", "power[2]")
    assert failure(model) == close((1 - Fraction(3, 4) ** 2) ** 2)


def test_a_function_that_counts_one_unit_of_a_group_uses_the_first(block, component):
    p = Fraction(1, 4)
    model = build_model(
        [
            block("a", 1, (component("power", 0.25, 2, "true"),)),
            block("b", 2, (component("power", 0.25, 1), component("gripper", 0.0))),
        ],
        name="m",
    )
    assert [event.name for event in model.states[1].tree.events] == ["power[1]", "gripper"]
    # The second function fails whenever the first unit has failed by then.
    assert failure(model) == close(1 - (1 - p) ** 2)
    first, second = solve(model).states
    assert (first.top_event, second.components[0].units) == (close(p**2), 1)


def _state(tree, names=("a",)):
    values = dict.fromkeys(tree.parameters, 0.125)
    return FunctionState("s", 1, tree, values, (NextStep("done", Fraction(1)),))


def _events(*names):
    return tuple(BasicEvent(name, "p") for name in names)


@pytest.mark.parametrize(
    ("gates", "events", "message"),
    [
        (
            [
                Gate("top", GateKind.OR, ("g", "h")),
                Gate("g", GateKind.AND, ("a", "b")),
                Gate("h", GateKind.AND, ("a", "c")),
            ],
            "abc",
            "'a' contains latent units and feeds g and h",
        ),
        (
            [Gate("top", GateKind.AND, ("g", "c")), Gate("g", GateKind.AND, ("a", "b"))],
            "abc",
            r"'a' is below gate 'top' \(and\); only 'or' gates are allowed between",
        ),
        (
            [Gate("top", GateKind.AND, ("a", "b", "c"))],
            "abc",
            "'a' is an input of gate 'top': it has other inputs, c;",
        ),
        (
            [Gate("top", GateKind.XOR, ("a", "b"))],
            "ab",
            "'a' is an input of gate 'top': its kind is 'xor'",
        ),
    ],
)
def test_trees_that_cannot_carry_hidden_failures_are_refused(gates, events, message):
    tree = FaultTree("top", tuple(gates), _events(*events))
    with pytest.raises(ModelError, match=f"state 's': .*{message}"):
        HybridModel("m", "s", (_state(tree),), (Parameter("p", 0.125),), ("a", "b"))


def test_units_of_one_group_may_fail_with_probabilities_of_their_own(exact):
    events = (BasicEvent("a", "p"), BasicEvent("b", "q"), BasicEvent("c", "q"))
    tree = FaultTree("top", (Gate("top", GateKind.ATLEAST, ("a", "b", "c"), 2),), events)
    steps = (NextStep("s", Fraction(2, 3)), NextStep("done", Fraction(1, 3)))
    state = FunctionState("s", 1, tree, {"p": 0.125, "q": 1e-9}, steps)
    parameters = (Parameter("p", 0.125), Parameter("q", 1e-9))
    model = HybridModel("m", "s", (state,), parameters, ("a", "b", "c"))
    total = exact.mission(model)
    assessment = solve(model)
    assert assessment.mission.failure_probability == close(total)
    for found in assessment.components:
        without = exact.mission(model, {found.name: Fraction(0)})
        assert found.fussell_vesely == close((total - without) / total)
    shares = {part.name: part.contribution for part in assessment.states[0].components}
    assert shares["q"] == close(assessment.states[0].top_event)


def test_a_hidden_pair_stands_beside_events_that_gates_share(exact):
    gates = (
        Gate("top", GateKind.OR, ("pair", "one", "two")),
        Gate("pair", GateKind.AND, ("a", "b")),
        Gate("one", GateKind.AND, ("x", "y")),
        Gate("two", GateKind.AND, ("x", "z")),
    )
    events = tuple(BasicEvent(name, "p" if name in "ab" else name) for name in "abxyz")
    values = {"p": 1e-6, "x": 0.01, "y": 0.02, "z": 0.03}
    steps = (NextStep("s", Fraction(2, 3)), NextStep("done", Fraction(1, 3)))
    state = FunctionState("s", 1, FaultTree("top", gates, events), values, steps)
    parameters = tuple(Parameter(name, value) for name, value in values.items())
    model = HybridModel("m", "s", (state,), parameters, ("a", "b"))
    total = exact.mission(model)
    assessment = solve(model)
    assert assessment.mission.failure_probability == close(total)
    for found in assessment.components:
        without = exact.mission(model, {found.name: Fraction(0)})
        assert found.fussell_vesely == close((total - without) / total)


def test_beyond_the_limit_the_figure_is_bounded_and_the_bound_is_reported(straight):
    model = straight(4, ("cell", 1e-3, 6, "required 2"), ("motor", 1e-7))
    whole = failure(model)
    assert hidden_states(model).most is None
    widths = []
    for limit in (4, 8, 12, 16):
        bounded = solve(model, limit=limit)
        (line,) = [each for each in bounded.assumptions if "bounded from above" in each]
        least, most = (
            float(line.split(" between ")[1].split(",")[0].split(" and ")[i]) for i in (0, 1)
        )
        assert least * (1 - 1e-6) <= whole <= bounded.mission.failure_probability * (1 + 1e-12)
        assert most == pytest.approx(bounded.mission.failure_probability, rel=1e-6)
        widths.append(bounded.mission.failure_probability / whole - 1)
    # One more hidden failure at once, and the bound is closer by orders.
    assert widths[1] < widths[0] / 10
    assert widths[2] < widths[1] / 10
    assert widths[3] < widths[2] / 10


def test_importances_of_a_bounded_mission_are_near_those_of_the_whole(straight):
    model = straight(4, *((f"pair{i}", 1e-6 * (i + 1), 2, "true") for i in range(6)), ("m", 1e-9))
    whole = {each.name: each for each in solve(model).components}
    for each in solve(model, limit=168).components:
        for measure in ("birnbaum", "fussell_vesely", "risk_reduction_worth", "tenfold"):
            assert getattr(each, measure) == pytest.approx(
                getattr(whole[each.name], measure), rel=1e-3
            )


def test_the_bound_holds_where_functions_tolerate_different_numbers(block, component):
    blocks = [
        block("a", 1, (component("x", 0.01, 3, "true"), component("y", 0.02, 2, "true"))),
        block(
            "b",
            2,
            (component("x", 0.01, 3, "required 2"), component("y", 0.01, 2, "true")),
            after={"a": "3/4", "done": "1/4"},
        ),
    ]
    model = build_model(blocks, name="m")
    whole = failure(model)
    for limit in (2, 6):
        assert failure_within(model, limit, whole)


def failure_within(model, limit, whole):
    bounded = solve(model, limit=limit)
    assert hidden_states(model, limit).most is not None
    mission = bounded.mission
    assert mission.failure_probability + mission.done_probability == close(1)
    return whole <= mission.failure_probability * (1 + 1e-12)


def test_a_thousand_units_of_which_many_may_fail_are_solved(straight):
    p = Fraction(1, 1000)
    model = straight(2, ("cell", float(p), 1000, "required 998"))
    failed = float(1 - (1 - p) ** 2)
    expected = math.fsum(
        math.comb(1000, k) * failed**k * (1 - failed) ** (1000 - k) for k in range(3, 60)
    )
    assert failure(model) == pytest.approx(expected, rel=1e-11)


def test_a_mission_that_is_sure_to_fail_by_hidden_failures_is_solved(straight):
    mission = solve(straight(2, ("pair", 1.0, 2, "true"))).mission
    assert (mission.failure_probability, mission.done_probability) == (1.0, 0.0)
    assert (mission.fixed_cycles, mission.visits_as_run) == (1.0, 1.0)


@pytest.mark.parametrize("part", [("pair", 0.0, 2, "true"), ("arm", 0.0, 1, "false")])
def test_what_cannot_fail_has_a_plain_zero_in_every_reading(straight, part):
    mission = solve(straight(2, part)).mission
    readings = (mission.failure_probability, mission.fixed_cycles, mission.visits_as_run)
    assert [repr(each) for each in readings] == ["0.0", "0.0", "0.0"]


@given(data=st.data())
def test_the_chain_written_out_has_the_same_figures(small_models, data):
    model = data.draw(small_models())
    solved = expanded_chain(model).solve(model.entry)
    absorption = solved.absorption()
    assessment = solve(model)
    assert absorption["done"] == close(assessment.mission.done_probability)
    for state in assessment.states:
        if state.expected_visits:
            assert absorption[state.failure_state] == close(state.absorption_probability)


def test_the_chain_written_out_names_what_has_failed(block, component):
    parts = (component("power", 0.25, 2, "true"), component("cell", 0.25, 3, "true"))
    # A function may have the very name that a state with failed units would get.
    blocks = [block("a", 1, parts), block("a (power 1 failed)", 2, parts)]
    model = build_model(blocks, name="m")
    chain = expanded_chain(model)
    assert len(chain.transitions) == 1 + 6
    assert next(iter(chain.transitions)) == "a"
    assert "a (power 1 failed) (power 1 failed, cell 2 failed)" in chain.transitions
    with pytest.raises(TooLargeError, match="hidden failures has more than 11 states"):
        expanded_chain(model, limit=11)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("redundancy", "most", "solved"),
    [
        ("required 2", 500, 200),
        ("true, spare warm 0.5, switch 0.1", 250, 60),
        pytest.param("required 2", 500, 502, marks=pytest.mark.slow),
        pytest.param("true, spare warm 0.5, switch 0.1", 250, 251, marks=pytest.mark.slow),
    ],
)
def test_groups_of_hundreds_of_units_are_solved_and_greater_ones_refused(
    block, component, redundancy, most, solved
):
    least = 2 if redundancy == "required 2" else 1
    groups = [component("motor", 0.9, units, redundancy) for units in (solved, 5_000)]
    few, many = (build_model([block("f", 1, [group])], name="m") for group in groups)
    assert 0.0 < failure(few) < 1.0
    with pytest.raises(TooLargeError, match=f"{5_000 - least} may have failed .* allowed: {most}"):
        solve(many)


def test_many_units_are_counted_as_few_are():
    for units in (17, 100, 999):
        for failed in (0, 16, 17, units // 2, units):
            found = failure_counts(units, 0.25, units)[failed]
            exact = math.comb(units, failed) * Fraction(1, 4) ** failed
            assert found == pytest.approx(float(exact * Fraction(3, 4) ** (units - failed)))
