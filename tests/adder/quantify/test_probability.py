import math
from dataclasses import replace

import pytest

from tracerisk.adder.quantify.probability import (
    UnitMission,
    failure_probability,
    terms_of,
    unit_hazard,
)
from tracerisk.common.hardware.load import UnitLoad
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, FailureMode, LoadLaw
from tracerisk.common.hardware.use import UnknownUseError, Use
from tracerisk.common.traced.elements import Exposure

PER_MINUTE = FailureFigure("probability", 6.674e-08, Basis.MINUTE)
HOURLY = FailureFigure("failure_rate", 3.6, Basis.HOUR)
"""One in a thousand seconds."""
JOINT = UnitMission("joint")
GRIPPER = UnitMission("gripper")


def used(seconds: float = 0.0, **fields: float) -> Use:
    """A use of so many seconds, all of them moving unless told otherwise."""
    return Use(replace(Exposure(moving_s=seconds, active_s=seconds), **fields))


def hazard(figures, use, mission=JOINT, **fields):
    figures = figures if isinstance(figures, tuple) else (figures,)
    return unit_hazard(terms_of(Component("part", figures, **fields), mission), use)


def probability(figures, use, mission=JOINT, **fields):
    return failure_probability(hazard(figures, use, mission, **fields))


def test_probability_per_minute_scales_with_the_exposure():
    assert probability(PER_MINUTE, used(60.0)) == pytest.approx(6.674e-08, rel=1e-14)
    assert probability(PER_MINUTE, used(6.0)) == pytest.approx(6.674e-09, rel=1e-7)
    assert probability(PER_MINUTE, used(0.0)) == 0.0


def test_two_halves_of_an_exposure_fail_as_the_whole():
    figure = FailureFigure("probability", 0.3, Basis.HOUR)
    half = probability(figure, used(1800.0))
    assert 1 - (1 - half) ** 2 == pytest.approx(0.3, rel=1e-14)


def test_failure_rate_is_exponential():
    figure = FailureFigure("failure_rate", 2.0, Basis.HOUR)
    assert probability(figure, used(1800.0)) == pytest.approx(1 - math.exp(-1), rel=1e-15)


def test_a_figure_per_visit_counts_where_the_component_is_active():
    figure = FailureFigure("probability", 1e-20, Basis.VISIT)
    assert probability(figure, Use(None)) == pytest.approx(1e-20, rel=1e-15)
    assert probability(figure, Use(None, is_active=False)) == 0.0


def test_certain_failure_stays_certain():
    figure = FailureFigure("probability", 1.0, Basis.MINUTE)
    assert probability(figure, used(1e-3)) == 1.0
    assert probability(figure, used(0.0)) == 0.0


def test_terms_of_one_unit_combine_as_independent_causes():
    figures = (
        FailureFigure("probability", 0.1, Basis.VISIT),
        FailureFigure("probability", 0.2, Basis.DEMAND),
    )
    assert probability(figures, used(starts=1)) == pytest.approx(0.28, rel=1e-15)


@pytest.mark.parametrize("basis", [Basis.MINUTE, Basis.DEMAND])
def test_unknown_use_is_an_error(basis):
    with pytest.raises(UnknownUseError, match="the exposure is not known"):
        probability(FailureFigure("probability", 0.1, basis), Use(None))


def test_what_is_always_active_has_no_demands():
    figure = FailureFigure("probability", 0.1, Basis.DEMAND)
    with pytest.raises(UnknownUseError, match="the number of demands is not known"):
        probability(figure, used(1.0), UnitMission(None))


DEMANDS = used(9.0, starts=2, grasps=3, releases=5)


@pytest.mark.parametrize(
    ("demand", "mission", "times"),
    [
        (None, JOINT, 2),
        (None, GRIPPER, 3),
        (None, UnitMission("contact"), 3),
        ("start", GRIPPER, 2),
        ("grasp", GRIPPER, 3),
        ("release", GRIPPER, 5),
    ],
)
def test_demands_are_counted(demand, mission, times):
    figure = FailureFigure("probability", 0.1, Basis.DEMAND, demand=demand)
    assert probability(figure, DEMANDS, mission) == pytest.approx(1 - 0.9**times, rel=1e-14)
    assert probability(figure, used(9.0), mission) == 0.0


def test_time_on_standby_counts_for_the_figures_of_standby_only():
    standby = replace(HOURLY, standby=True)
    use = replace(used(2.0), standby_s=5.0)
    assert hazard(standby, use) == pytest.approx(0.005, rel=1e-15)
    assert hazard((HOURLY, standby), use) == pytest.approx(0.007, rel=1e-15)
    with pytest.raises(UnknownUseError, match="the time on standby is not known"):
        hazard(standby, used(2.0))


# 5 s moving, of which 2 s with a grasp; 7 s holding, of which 3 s with one; 1 s of grasp alone.
STATES = Use(
    Exposure(
        moving_s=5.0,
        holding_s=7.0,
        grasping_s=6.0,
        active_s=13.0,
        grasping_moving_s=2.0,
        starts=2,
        grasps=3,
        releases=5,
    )
)


@pytest.mark.parametrize(
    ("when", "seconds"),
    [
        (("moving",), 5.0),
        (("holding",), 7.0),
        (("grasping",), 6.0),
        (("moving", "holding"), 12.0),
        (("grasping", "moving"), 9.0),
        (("holding", "grasping"), 10.0),
        (("holding", "moving", "grasping"), 13.0),
        (("grasp", "grasping"), 6.0),
    ],
)
def test_a_failure_mode_counts_while_any_of_its_states_lasts(when, seconds):
    modes = (FailureMode("one", 0.25, when),)
    expected = pytest.approx(0.25e-3 * seconds, rel=1e-14)
    assert hazard(HOURLY, STATES, GRIPPER, modes=modes) == expected
    # Modes name their states themselves, whatever the setting counts.
    only_moving = replace(GRIPPER, states=("moving",))
    assert hazard(HOURLY, STATES, only_moving, modes=modes) == expected


def test_the_shares_of_failure_modes_add_up():
    modes = (
        FailureMode("lost_torque", 0.6, ("moving", "holding")),
        FailureMode("jam", 0.3, ("moving",)),
    )
    assert hazard(HOURLY, STATES, modes=modes) == pytest.approx(1e-3 * (0.6 * 12 + 0.3 * 5))


@pytest.mark.parametrize("states", [None, ("moving",)])
def test_modes_that_say_nothing_of_uses_move_no_figure(states):
    modes = (FailureMode("lost_torque", 0.3, ()), FailureMode("jam", 0.7, ()))
    mission = replace(GRIPPER, states=states)
    demand = FailureFigure("probability", 0.1, Basis.DEMAND)
    for figure in (HOURLY, demand):
        assert hazard(figure, STATES, mission, modes=modes) == hazard(figure, STATES, mission)


def test_modes_count_the_demands_that_they_name():
    modes = (
        FailureMode("fails_to_close", 0.5, ("grasp",)),
        FailureMode("fails_to_open", 0.3, ("release",)),
        FailureMode("drops", 0.2, ("grasping",)),
    )
    log = -math.log1p(-0.1)
    any_demand = FailureFigure("probability", 0.1, Basis.DEMAND)
    assert hazard(any_demand, STATES, GRIPPER, modes=modes) == pytest.approx(
        log * (0.5 * 3 + 0.3 * 5), rel=1e-14
    )
    to_open = replace(any_demand, demand="release")
    assert hazard(to_open, STATES, GRIPPER, modes=modes) == pytest.approx(log * 0.3 * 5, rel=1e-14)
    assert hazard(HOURLY, STATES, GRIPPER, modes=modes) == pytest.approx(0.2e-3 * 6, rel=1e-14)


def test_the_setting_says_which_time_counts_without_modes():
    assert hazard(HOURLY, STATES, GRIPPER) == pytest.approx(13e-3, rel=1e-15)
    only_moving = replace(GRIPPER, states=("moving",))
    assert hazard(HOURLY, STATES, only_moving) == pytest.approx(5e-3, rel=1e-15)


LAW = LoadLaw(reference_load=0.5, wearing_share=0.6, exponent=3.0, reference_speed=0.2)
"""Of wear 0.1 s: 0.1 / (0.2 x 0.5^3) = 4 s at reference load and speed."""
WEAR = (0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0)


def test_the_load_law_counts_the_wear_for_the_wearing_share():
    use = used(3.0, wear=WEAR, travel_s=0.6)
    loaded = replace(JOINT, load=UnitLoad(LAW, 0.2))
    assert hazard(HOURLY, use, loaded) == pytest.approx(1e-3 * (0.4 * 3 + 0.6 * 4), rel=1e-14)
    # A unit that moves at reference load and speed throughout fails as without the law.
    at_reference = used(3.0, wear=(0.0, 0.0, 3.0 * 0.2 * 0.5**3, 0.0, 0.0, 0.0, 0.0))
    assert hazard(HOURLY, at_reference, loaded) == pytest.approx(3e-3, rel=1e-14)


def test_holding_adds_no_wear():
    use = used(3.0, holding_s=2.0, active_s=5.0, wear=WEAR)
    loaded = replace(JOINT, load=UnitLoad(LAW, 0.2))
    assert hazard(HOURLY, use, loaded) == pytest.approx(1e-3 * (0.4 * 5 + 0.6 * 4), rel=1e-14)

    def split(*whens):
        modes = tuple(FailureMode(str(n), 0.25, when) for n, when in enumerate(whens))
        return hazard(HOURLY, use, loaded, modes=modes)

    assert split(("holding",)) == pytest.approx(0.25e-3 * 0.4 * 2, rel=1e-14)
    both = split(("moving",), ("holding",))
    assert both == pytest.approx(split(("moving", "holding")), rel=1e-14)


def test_the_load_law_leaves_demands_standby_and_visits_alone():
    figures = (
        FailureFigure("probability", 0.1, Basis.DEMAND),
        FailureFigure("probability", 0.2, Basis.VISIT),
        replace(HOURLY, standby=True),
    )
    use = replace(used(3.0, wear=WEAR, starts=2), standby_s=4.0)
    loaded = replace(JOINT, load=UnitLoad(LAW, 0.2))
    assert hazard(figures, use, loaded) == hazard(figures, use)


def test_what_ages_fails_at_the_mean_rate_of_its_mission():
    figure = FailureFigure("weibull", 10.0, Basis.HOUR, shape=2.0)
    mission = replace(JOINT, in_use_s=3600.0)
    # From 4 h to 5 h of age: (25 - 16) / 100, a sixth of it in ten minutes.
    assert hazard(figure, used(600.0), mission, age_s=4 * 3600.0) == pytest.approx(0.015, rel=1e-14)
    assert hazard(figure, used(0.0), replace(mission, in_use_s=0.0)) == 0.0


def test_a_term_that_is_not_used_does_not_fail():
    sure = FailureFigure("probability", 1.0, Basis.DEMAND)
    assert probability(sure, used(1.0)) == 0.0
    assert probability((sure, HOURLY), used(1.0)) == pytest.approx(1 - math.exp(-1e-3), rel=1e-14)
