import math
from fractions import Fraction
from itertools import pairwise

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import build_model, solve
from tracerisk.prm.questions.set_values import log_spaced, set_values, sweep, value_of, with_values

LOOP = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}


def close(expected):
    return pytest.approx(float(expected), rel=1e-12, abs=0.0)


@pytest.fixture(scope="module")
def case(case_study):
    return build_model(case_study, profile=LOOP, name="case")


def test_a_set_figure_gives_what_the_blocks_with_that_figure_give(block, component):
    def model(gripper):
        parts = (component("gripper", gripper), component("motor", 1e-7, 7))
        return build_model([block("pick", 1, parts, after={"done": 1})], name="m")

    changed = with_values(model(1e-8), {"gripper": 1e-6})
    assert changed == model(1e-6)


def test_a_state_with_a_smaller_figure_keeps_its_part_of_theta(case):
    changed = with_values(case, {"electric_motor": 2 * 1.30644e-07})
    by_name = {state.name: state.probabilities["electric_motor"] for state in changed.states[:4]}
    assert by_name["place_position"] == 2 * 1.30644e-07
    assert by_name["init"] == close(2 * 9.5e-08)


def test_the_mission_after_a_change_equals_exact_rationals(case, exact):
    changed = with_values(case, {"electric_motor": 10 * 1.30644e-07, "gripper": 0.0})
    expected = exact.mission(case, {"electric_motor": Fraction(10), "gripper": Fraction(0)})
    assert solve(changed).mission.failure_probability == close(expected)


def test_nothing_set_changes_nothing(case):
    assert with_values(case, {}) == case


def test_a_parameter_of_zero_is_set_in_all_its_states(block, component):
    blocks = [
        block(name, number, (component("motor", 0.0),)) for number, name in enumerate("ab", 1)
    ]
    changed = with_values(build_model(blocks, name="m"), {"motor": 0.25})
    assert [state.probabilities["motor"] for state in changed.states] == [0.25, 0.25]


def test_a_component_with_a_common_cause_is_set_as_a_whole(block, component):
    def model(value):
        parts = (component("power", value, 2, "true, common_cause 0.1"),)
        return build_model([block("a", 1, parts)], name="m")

    changed = with_values(model(1e-6), {"power": 1e-4})
    assert value_of(changed, "power") == close(1e-4)
    assert solve(changed).mission.failure_probability == close(
        solve(model(1e-4)).mission.failure_probability
    )
    (reported,) = set_values(model(1e-6), {"power": 1e-4})
    assert (reported.name, reported.before, reported.now) == ("power", close(1e-6), 1e-4)
    with pytest.raises(ModelError, match=r"'power \{own\}' is set twice"):
        with_values(model(1e-6), {"power": 1e-4, "power {own}": 1e-4})


def test_an_unknown_parameter_is_reported_with_those_there_are(case):
    with pytest.raises(
        ModelError,
        match=r"no parameter 'griper' in 'case'; did you mean 'gripper'\? "
        "allowed: control_system, electric_motor, gripper, power_system",
    ):
        with_values(case, {"griper": 1e-6})


@pytest.mark.parametrize("value", [-1e-9, 1.5, math.nan])
def test_a_value_outside_0_to_1_is_refused(case, value):
    with pytest.raises(ModelError, match=r"'gripper' is set to .*; allowed: 0 to 1"):
        with_values(case, {"gripper": value})


def test_log_spaced_values_keep_their_ends_and_their_ratio():
    values = log_spaced(1e-9, 1e-5, 9)
    assert (values[0], values[-1], len(values)) == (1e-9, 1e-5, 9)
    ratios = [after / before for before, after in pairwise(values)]
    assert ratios == pytest.approx([math.sqrt(10)] * 8, rel=1e-12)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (1e-3, 1e-3), (1e-3, 1e-4), (1.0, math.inf)])
def test_a_range_that_cannot_be_swept_is_refused(low, high):
    with pytest.raises(ModelError, match="give 0 < low < high"):
        log_spaced(low, high, 3)
    with pytest.raises(ModelError, match="a sweep of 1 values; give at least 2"):
        log_spaced(1e-3, 1e-2, 1)


def test_each_point_of_a_sweep_is_the_model_solved_there(case, exact):
    theta = 1.30644e-07
    found = sweep(case, "electric_motor", (theta, 10 * theta, 100 * theta))
    assert found.before == theta
    for point, scale in zip(found.points, (1, 10, 100), strict=True):
        expected = exact.mission(case, {"electric_motor": Fraction(scale)})
        assert point.mission.failure_probability == close(expected)
