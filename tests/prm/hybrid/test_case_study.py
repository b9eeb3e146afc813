"""The published case study: Grimmeisen et al. 2024, Tables I and II."""

from fractions import Fraction

import pytest

from tracerisk.prm import build_model, solve

PROFILE = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}

PUBLISHED = {
    "init": ("7.38e-07", "7.38e-06"),
    "pick_position": ("6.65e-07", "6.65e-06"),
    "pick": ("7.38e-07", "7.38e-06"),
    "place_position": ("9.15e-07", "9.14e-06"),
    "place": ("7.34e-08", "7.34e-07"),
}


def printed(value: float) -> str:
    return f"{value:.2e}"


@pytest.fixture(scope="module")
def assessment(case_study):
    return solve(build_model(case_study, profile=PROFILE, name="case study"))


@pytest.mark.parametrize("function", PUBLISHED)
def test_every_printed_figure_of_the_published_case_comes_out(assessment, function):
    state = next(state for state in assessment.states if state.name == function)
    assert PUBLISHED[function] == (printed(state.top_event), printed(state.absorption_probability))


def test_the_published_case_runs_ten_cycles_and_its_figures_differ_as_theory_says(assessment):
    mission = assessment.mission
    assert mission.expected_cycles == pytest.approx(10, rel=1e-14)
    # The geometric chain fails less often by (N-1) f / 2 relative, to first order.
    expected = 9 * mission.cycle_failure_probability / 2
    gap = mission.fixed_cycles / mission.failure_probability - 1
    assert gap == pytest.approx(expected, rel=1e-3)
    assert mission.visits_as_run == pytest.approx(mission.fixed_cycles, rel=1e-12)


def test_the_motors_matter_most_in_the_published_case(assessment):
    names = [component.name for component in assessment.components]
    assert names == ["electric_motor", "gripper", "power_system", "control_system"]
