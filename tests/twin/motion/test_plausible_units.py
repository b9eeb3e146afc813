"""Goals out of range in words, with a guess of the unit that was meant."""

import math

import pytest

from tracerisk.twin.motion.plausible_units import (
    are_radians_likely,
    cut_line,
    floored_percent,
    length_guess,
    past_limits,
    shown_limits,
    speed_guess,
)
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import load_robot

PANDA = load_robot("panda")
ELBOW, FINGER = PANDA.joint("panda_joint4"), PANDA.joint("panda_finger_joint1")
TURN_OF_UR = load_robot("ur5e").joint("shoulder_pan_joint")


@pytest.mark.parametrize(
    ("value", "guess"),
    [(-130.0, " (degrees?)"), (90.0, " (degrees?)"), (0.0, ""), (6.0, ""), (720.0, ""), (-3.5, "")],
)
def test_more_than_a_turn_on_a_joint_that_cannot_make_one_may_be_degrees(value, guess):
    assert shown_limits(ELBOW, value) == f"[-3.0718, -0.0698]{guess}"


@pytest.mark.parametrize(
    ("value", "guess"), [(5.0, " (degrees?)"), (-4.0, " (degrees?)"), (4.71, ""), (-2.9, "")]
)
def test_a_whole_number_past_the_limits_may_be_degrees(value, guess):
    assert shown_limits(PANDA.joint("panda_joint1"), value).endswith(f"]{guess}")


@pytest.mark.parametrize(
    ("speed", "guess"),
    [(20.0, " (deg/s?)"), (-100.0, " (deg/s?)"), (2.0, ""), (-2.175, ""), (500.0, "")],
)
def test_a_velocity_past_its_limit_may_be_degrees_per_second(speed, guess):
    assert speed_guess(PANDA.joint("panda_joint1"), speed) == guess


@pytest.mark.parametrize(
    ("goal", "likely"),
    [
        ([0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], True),
        ([0.0, 1.57, 0.0, -1.2, 0.0, 0.0, 0.0], True),
        ([0.0, 0.0, 5.0, -2.0, 0.0, 0.0, 0.0], False),
        ([0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0], False),
        ([0.5, -45.0, 0.0, -135.0, 0.0, 90.0, 45.0], False),
        ([0.0] * 7, False),
        ([0.5, 0.5, 0.0, 2.5, 0.0, 0.0, 0.0], False),
    ],
)
def test_small_broken_numbers_for_several_joints_may_be_radians(goal, likely):
    assert are_radians_likely(PANDA.arm_joints, goal) is likely


def test_within_the_limits_of_a_joint_that_makes_a_turn_nothing_is_guessed():
    assert "degrees" not in shown_limits(TURN_OF_UR, 6.2)
    assert shown_limits(TURN_OF_UR, -90.0).endswith(" (degrees?)")


def test_a_slide_past_a_hundred_times_its_range_may_be_in_mm():
    assert shown_limits(FINGER, 40.0) == "[0, 0.04] (mm?)"
    assert shown_limits(FINGER, 0.5) == "[0, 0.04]"


def test_a_goal_past_a_limit_names_the_limit_and_one_within_says_nothing():
    assert past_limits(ELBOW, 0.0, 0.02) == "0, past its limits [-3.0718, -0.0698]"
    assert past_limits(ELBOW, -0.06, 0.02) == ""


def test_a_pose_a_hundred_times_out_of_reach_may_be_in_mm_and_one_at_the_origin_in_m():
    assert length_guess((300.0, 0.0, 400.0), 0.6) == " (mm?)"
    assert length_guess((3.0, 0.0, 4.0), 0.6) == ""
    assert length_guess((0.0003, 0.0, 0.0004), 0.6) == " (m, where mm are expected?)"
    assert length_guess((0.0, 0.0, 0.0), 0.6) == ""


@pytest.mark.parametrize(
    ("fraction", "shown"), [(0.9999, "99%"), (1.0, "100%"), (0.005, "0%"), (0.29, "29%")]
)
def test_what_is_not_whole_is_not_a_hundred_per_cent(fraction, shown):
    assert floored_percent(fraction) == shown


def test_the_line_that_ends_early_says_how_much_of_it_and_where_to():
    here = Pose((0.3, 0.0, 0.4), (1.0, 0.0, 0.0, 0.0))
    goal = Pose((300.0, 0.0, 400.0), (1.0, 0.0, 0.0, 0.0))
    assert cut_line(goal, 0.004, here) == (
        "only 0% of the line to (300.000, 0.000, 400.000) m (mm?) can be followed"
    )
    assert math.isclose(math.hypot(*here.position), 0.5)
