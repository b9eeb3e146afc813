import math
import subprocess
import sys
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tracerisk.prm import (
    FIGURE_STATEMENT,
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

LOOP = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}


def close(expected):
    return pytest.approx(float(expected), rel=1e-12, abs=0.0)


@pytest.fixture(scope="module")
def case(case_study):
    return build_model(case_study, profile=LOOP, name="case")


@pytest.fixture(scope="module")
def branching(block, component):
    """A chain with a branch, a retry and a return, on single, series and parallel parts."""
    motor, loaded = component("motor", 2e-6, 3), component("motor", 5e-6, 2)
    power = component("power", 1e-5, 2, True)
    gripper = component("gripper", 3e-4)
    blocks = [
        block("home", 1, (motor, power), after={"pick": "3/4", "inspect": "1/4"}),
        block("pick", 2, (motor, gripper, power), after={"pick": "1/10", "place": "9/10"}),
        block("inspect", 3, (power,), after={"home": "1/2", "done": "1/2"}),
        block("place", 4, (loaded, gripper), after={"home": "4/5", "done": "1/5"}),
    ]
    return build_model(blocks, name="branching")


def test_one_state_in_a_loop_equals_the_answer_on_paper(block, component):
    # F = p sum_n ((1-p) r)^n = p / (1 - (1-p) r), with p = 1/4, r = 1/2: F = 2/5.
    blocks = [block("a", 1, (component("motor", 0.25),), after={"a": "1/2", "done": "1/2"})]
    mission = solve(build_model(blocks, name="m")).mission
    assert mission.failure_probability == close(Fraction(2, 5))
    assert mission.done_probability == close(Fraction(3, 5))
    assert mission.cycle_failure_probability == close(Fraction(1, 4))
    assert mission.expected_cycles == close(2)
    assert mission.fixed_cycles == close(1 - Fraction(3, 4) ** 2)
    assert mission.visits_as_run == close(1 - Fraction(3, 4) ** 2)


@pytest.mark.parametrize("name", ["case", "branching"])
def test_the_mission_equals_exact_rationals(exact, request, name):
    model = request.getfixturevalue(name)
    expected = exact.mission(model)
    mission = solve(model).mission
    assert mission.failure_probability == close(expected)
    assert mission.done_probability == close(1 - expected)


def test_absorptions_sum_to_the_failure_and_follow_from_the_visits(branching):
    assessment = solve(branching)
    for state in assessment.states:
        assert state.absorption_probability == close(state.expected_visits * state.top_event)
    total = math.fsum(state.absorption_probability for state in assessment.states)
    assert total == close(assessment.mission.failure_probability)


def test_visits_of_the_failure_free_chain_are_the_counts_of_the_run(block, component):
    # The run a b a b b c: a twice, b three times, c once.
    motor = component("motor", 0.125)
    blocks = [
        block("a", 1, (motor,), after={"b": 1}),
        block("b", 2, (motor,), after={"a": "1/3", "b": "1/3", "c": "1/3"}),
        block("c", 3, (motor,), after={"done": 1}),
    ]
    mission = solve(build_model(blocks, name="m")).mission
    assert mission.visits_as_run == close(1 - Fraction(7, 8) ** 6)


_ROUNDS = {
    "once": ({"a": {"b": 1}, "b": {"done": 1}}, 1),
    "equal rounds": ({"a": {"b": 1}, "b": {"a": "2/3", "done": "1/3"}}, 3),
    "one function": ({"a": {"a": "2/3", "done": "1/3"}}, 3),
    "branches": (
        {
            "a": {"b": "1/2", "c": "1/2"},
            "b": {"a": 1},
            "c": {"a": "1/2", "done": "1/2"},
        },
        4,
    ),
    "loop behind the entry": ({"a": {"b": 1}, "b": {"b": "2/3", "done": "1/3"}}, 1),
    "home at the end": (
        {
            "a": {"b": "1/2", "done": "1/2"},
            "b": {"c": 1},
            "c": {"b": "2/3", "a": "1/3"},
        },
        None,
    ),
    "home twice at the start": (
        {"a": {"a": "1/2", "b": "1/2"}, "b": {"b": "2/3", "done": "1/3"}},
        None,
    ),
    "park at the end": (
        {"a": {"b": 1}, "b": {"a": "2/3", "c": "1/3"}, "c": {"done": 1}},
        None,
    ),
}
"""What follows each function, the entry first, and the cycles that a mission has, if any."""


@pytest.mark.parametrize(("following", "cycles"), _ROUNDS.values(), ids=_ROUNDS)
def test_a_mission_has_cycles_only_where_it_is_rounds_from_its_entry(
    block, component, following, cycles
):
    blocks = [
        block(name, number, (component("motor", 0.125),), after=after)
        for number, (name, after) in enumerate(following.items(), start=1)
    ]
    mission = solve(build_model(blocks, name="m")).mission
    assert (mission.cycle_failure_probability is None) == (cycles is None)
    assert mission.expected_cycles == (None if cycles is None else close(cycles))


def test_a_mission_that_is_sure_to_fail_is_solved(block, component):
    blocks = [block("a", 1, (component("motor", 1.0),), after={"a": "1/2", "done": "1/2"})]
    assessment = solve(build_model(blocks, name="m"))
    mission = assessment.mission
    assert mission.failure_probability == 1.0
    assert mission.done_probability == 0.0
    assert mission.fixed_cycles == 1.0
    assert mission.visits_as_run == 1.0
    assert assessment.components[0].birnbaum == close(Fraction(1, 2))


def test_a_survival_too_small_to_show_beside_one_is_solved(block, component):
    # Each unit survives with 2^-52; 1 - p of the computed p would be zero.
    parts = (component("motor", 1.0 - 2.0**-52, 2),)
    mission = solve(build_model([block("a", 1, parts)], name="m")).mission
    assert mission.done_probability == 2.0**-104
    assert (mission.fixed_cycles, mission.visits_as_run) == (1.0, 1.0)


def test_splitting_a_function_in_two_halves_of_its_exposure_moves_nothing(block, component):
    def probability(minutes: float) -> float:
        return -math.expm1(minutes * math.log1p(-9.5e-08))

    def mission(parts):
        blocks = [
            block(f"part{i}", i, (component("motor", probability(minutes), 7),))
            for i, minutes in enumerate(parts, 1)
        ]
        last = blocks[-1].name
        profile = {last: {"part1": Fraction(9, 10), "done": Fraction(1, 10)}}
        return solve(build_model(blocks, profile=profile, name="m")).mission.failure_probability

    assert mission([0.5, 0.5]) == pytest.approx(mission([1.0]), rel=1e-6)
    assert mission([0.2, 0.3, 0.5]) == pytest.approx(mission([1.0]), rel=1e-6)


def test_splitting_a_pair_that_is_renewed_at_each_visit_moves_the_figure_and_is_an_assumption(
    block, component
):
    renewed = "true, detected each_visit"
    whole = build_model([block("a", 1, (component("power", 2e-4, 2, renewed),))], name="m")
    half = component("power", 1e-4, 2, renewed)
    split = build_model([block("a", 1, (half,)), block("b", 2, (half,))], name="m")
    ratio = solve(whole).mission.failure_probability / solve(split).mission.failure_probability
    assert ratio == pytest.approx(2.0, rel=1e-6)
    (line,) = solve(whole).assumptions
    assert line.startswith("redundant units with detection at each visit")
    assert line.endswith("depend on how the code is divided into functions")


def test_assumptions_are_reported_only_where_they_are_made(block, component):
    straight = solve(build_model([block("a", 1, (component("motor", 1e-6, 3),))], name="m"))
    assert straight.assumptions == ()
    looped = build_model([block("a", 1, after={"a": "1/2", "done": "1/2"})], name="m")
    (line,) = solve(looped).assumptions
    assert "geometric" in line
    assert straight.statement == FIGURE_STATEMENT


def importances(model):
    return {component.name: component for component in solve(model).components}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["case", "branching"])
def test_birnbaum_equals_a_finite_difference_in_exact_rationals(exact, request, name):
    model = request.getfixturevalue(name)
    step = Fraction(1, 10**6)
    for component, found in importances(model).items():
        up = exact.mission(model, {component: 1 + step})
        down = exact.mission(model, {component: 1 - step})
        expected = (up - down) / (2 * step * Fraction(found.theta))
        # The central difference is off by about step squared.
        assert found.birnbaum == pytest.approx(float(expected), rel=1e-11)
        criticality = expected * Fraction(found.theta) / exact.mission(model)
        assert found.criticality == pytest.approx(float(criticality), rel=1e-11)


@pytest.mark.parametrize("name", ["case", "branching"])
def test_fussell_vesely_and_the_worths_equal_exact_rationals(exact, request, name):
    model = request.getfixturevalue(name)
    total = exact.mission(model)
    for component, found in importances(model).items():
        without = exact.mission(model, {component: Fraction(0)})
        assert found.without == close(without)
        assert found.fussell_vesely == close((total - without) / total)
        assert found.risk_reduction_worth == close(total / without)
        assert found.tenfold == close(exact.mission(model, {component: Fraction(10)}) / total)


def test_a_difference_far_below_the_top_keeps_its_digits(exact, block, component):
    # A pair of 1e-20 beside a part of 1/8: the pair's share of the risk is 1e-40.
    parts = (component("pair", 1e-20, 2, True), component("weak", 0.125))
    model = build_model([block("a", 1, parts, after={"a": "1/2", "done": "1/2"})], name="m")
    total = exact.mission(model)
    without = exact.mission(model, {"pair": Fraction(0)})
    found = importances(model)["pair"]
    assert found.fussell_vesely == close((total - without) / total)
    assert 0.0 < found.fussell_vesely < 1e-38


def test_a_single_point_of_failure_achieves_certain_failure(case):
    assessment = solve(case)
    total = assessment.mission.failure_probability
    for component in assessment.components:
        assert component.risk_achievement_worth == close(1 / total)


def test_a_part_of_one_branch_only_achieves_the_failure_of_that_branch(block, component):
    blocks = [
        block("start", 1, after={"left": "1/4", "right": "3/4"}),
        block("left", 2, (component("rare", 1e-3),), after={"done": 1}),
        block("right", 3, (component("common", 1e-3),), after={"done": 1}),
    ]
    found = importances(build_model(blocks, name="m"))["rare"]
    assert found.risk_achievement_worth == close((Fraction(1, 4) + Fraction(3, 4000)) * 1000)


def test_the_only_component_has_an_infinite_reduction_worth(block, component):
    found = importances(build_model([block("a", 1, (component("motor", 1e-6),))], name="m"))
    assert found["motor"].risk_reduction_worth == math.inf
    assert found["motor"].fussell_vesely == close(1)
    assert found["motor"].birnbaum == close(1)
    assert found["motor"].tenfold == close(10)


def test_a_component_that_never_fails_has_importance_zero_and_still_a_slope(block, component):
    parts = (component("ideal", 0.0, 2), component("motor", 0.25))
    found = importances(build_model([block("a", 1, parts)], name="m"))["ideal"]
    assert (found.criticality, found.fussell_vesely, found.risk_reduction_worth) == (0.0, 0.0, 1.0)
    assert found.birnbaum == close(2 * Fraction(3, 4))


def test_a_model_without_any_risk_has_finite_shares(block, component):
    found = importances(build_model([block("a", 1, (component("ideal", 0.0),))], name="m"))["ideal"]
    assert (found.criticality, found.fussell_vesely, found.risk_reduction_worth) == (0.0, 0.0, 1.0)
    assert found.risk_achievement_worth == math.inf
    assert found.tenfold == 1.0


def test_shares_by_state_and_by_unit_sum_to_the_whole(branching):
    for component in solve(branching).components:
        for shares in (component.by_state, component.by_unit):
            assert math.fsum(share.birnbaum for share in shares) == close(component.birnbaum)
            assert math.fsum(share.criticality for share in shares) == close(component.criticality)
    motor = importances(branching)["motor"]
    assert [share.name for share in motor.by_state] == ["home", "pick", "place"]
    assert [share.name for share in motor.by_unit] == ["motor[1]", "motor[2]", "motor[3]"]
    # The loaded state has two motors only.
    assert motor.by_unit[2].birnbaum < motor.by_unit[0].birnbaum


def test_components_are_ordered_by_what_is_lost_without_them(branching):
    names = [component.name for component in solve(branching).components]
    assert names == ["gripper", "motor", "power"]


def test_contributions_say_what_each_component_adds_to_a_function(block, component):
    parts = (component("motor", 0.1, 2), component("power", 0.1, 3, True))
    (state,) = solve(build_model([block("a", 1, parts)], name="m")).states
    motor, power = state.components
    assert (motor.units, motor.required, motor.probability) == (2, 2, 0.1)
    assert (power.units, power.required, power.probability) == (3, 1, 0.1)
    assert motor.contribution == close((1 - 0.001) * 0.19)
    assert power.contribution == close(0.81 * 0.001)


def test_a_k_of_n_gate_says_how_many_units_it_needs():
    events = tuple(BasicEvent(f"cell{i}", "cell") for i in range(5))
    gate = Gate("cells", GateKind.ATLEAST, tuple(event.name for event in events), k=3)
    step = (NextStep("done", Fraction(1)),)
    state = FunctionState("a", 1, FaultTree("cells", (gate,), events), {"cell": 0.5}, step)
    assessment = solve(HybridModel("m", "a", (state,), (Parameter("cell", 0.5),)))
    assert assessment.states[0].components[0].required == 3
    assert assessment.mission.failure_probability == close(Fraction(1, 2))


def test_a_state_may_have_a_tree_that_shares_an_event():
    gates = (
        Gate("top", GateKind.OR, ("left", "right")),
        Gate("left", GateKind.AND, ("e", "f")),
        Gate("right", GateKind.AND, ("e", "g")),
    )
    tree = FaultTree("top", gates, tuple(BasicEvent(name, "t") for name in "efg"))
    state = FunctionState("pick", 1, tree, {"t": 0.5}, (NextStep("done", Fraction(1)),))
    assessment = solve(HybridModel("m", "pick", (state,), (Parameter("t", 0.5),)))
    assert assessment.mission.failure_probability == close(Fraction(3, 8))


@pytest.mark.slow
@given(data=st.data())
def test_many_random_models_equal_exact_rationals(exact, block, component, data):
    _equals_exact_rationals(exact, block, component, data)


@settings(max_examples=8, deadline=None)
@given(data=st.data())
def test_random_models_equal_exact_rationals(exact, block, component, data):
    _equals_exact_rationals(exact, block, component, data)


def _equals_exact_rationals(exact, block, component, data):
    size = data.draw(st.integers(1, 4))
    names = [f"f{i}" for i in range(size)]
    blocks = []
    for index, name in enumerate(names):
        parts = tuple(
            component(
                part,
                data.draw(st.floats(1e-28, 0.99)),
                data.draw(st.integers(1, 2)),
                data.draw(st.booleans()),
            )
            for part in data.draw(st.lists(st.sampled_from("xyz"), unique=True, max_size=3))
        )
        weights = {t: data.draw(st.integers(0, 9)) for t in [*names, "done"]}
        weights["done"] += 1
        total = sum(weights.values())
        after = {t: Fraction(w, total) for t, w in weights.items()}
        blocks.append(block(name, index + 1, parts, after=after))
    model = build_model(blocks, name="random")
    expected = exact.mission(model)
    assume(expected > 0)
    assessment = solve(model)
    assert assessment.mission.failure_probability == close(expected)
    for found in assessment.components:
        without = exact.mission(model, {found.name: Fraction(0)})
        assert found.fussell_vesely == close((expected - without) / expected)


def test_importing_and_solving_needs_nothing_heavy():
    code = (
        "import sys, tracerisk.prm, tracerisk.prm.formats;"
        "heavy = {'numpy', 'mujoco', 'dm_control', 'libcst', 'rich', 'ruamel'};"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("share", [1e-12, 0.1, 0.9])
def test_a_common_cause_keeps_the_success_of_units_that_surely_fail(block, component, share):
    pair = component("power", 1.0, 2, f"true, common_cause {share!r}")
    found = solve(build_model([block("a", 1, (pair,))], name="m")).mission
    b = Fraction(share)
    assert found.done_probability == pytest.approx(float((1 - b) * (1 - (1 - b) ** 2)), rel=1e-15)


def test_spares_keep_the_success_of_units_that_nearly_surely_fail(block, component):
    q = 2.0**-50
    pair = component("power", 1.0 - q, 2, "true, spare cold")
    found = solve(build_model([block("a", 1, (pair,))], name="m")).mission
    assert found.done_probability == pytest.approx(q * (1 + 50 * math.log(2)), rel=1e-13)
