"""Which end of a gripper is open: its pads say so, whatever the sign of its joints."""

from dataclasses import replace

import numpy as np
import pytest

from tracerisk.twin.physics.motion import JointTrajectory
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.assumed_names import with_assumed_names
from tracerisk.twin.robots.gripper_ends import (
    GripperEnds,
    driver_ends,
    gripper_ends,
    pad_distance,
    position_at,
    width_at,
)
from tracerisk.twin.robots.robot import load_robot, robot_names
from tracerisk.twin.simulation.twin import Twin

CLOSE_BY_GROWING = {
    "gen3",
    "gen3_6dof",
    "gen3_lite",
    "j2n6s300",
    "j2s6s300",
    "j2s7s300",
    "xarm6",
    "xarm7",
}
"""The shipped robots whose pads come nearer while the first joint grows."""


def test_the_pads_of_every_shipped_gripper_say_which_end_is_open():
    growing = set()
    for name in robot_names():
        robot = load_robot(name)
        for gripper in robot.grippers:
            ends = gripper_ends(robot, gripper)
            assert {ends.closed, ends.opened} == {gripper.least, gripper.opening}
            apart = [pad_distance(robot, gripper, end) for end in (ends.closed, ends.opened)]
            assert apart[1] > apart[0] + 0.02, name
            if ends.closed > ends.opened:
                growing.add(name)
    assert growing == CLOSE_BY_GROWING


def test_named_states_lie_between_the_ends_and_in_their_order():
    for name in robot_names():
        robot = load_robot(name)
        for gripper in robot.grippers:
            ends, named = gripper_ends(robot, gripper), driver_ends(robot, gripper)
            closed, opened = ends.share(named.closed), ends.share(named.opened)
            assert -1e-9 <= closed < opened <= 1.0 + 1e-9, name


def test_named_states_that_contradict_the_pads_are_not_the_ends():
    robot = load_robot("panda")
    (gripper,) = robot.grippers
    first = gripper.joints[0]
    swapped = {"hand": {"open": {first: 0.0}, "close": {first: 0.04}}}
    assert driver_ends(replace(robot, named_states=swapped), gripper) == GripperEnds(0.0, 0.04)


def test_named_states_say_what_a_single_pad_cannot():
    robot = load_robot("so100")
    (gripper,) = robot.grippers
    single = replace(gripper, pads=gripper.pads[:1])
    assert gripper_ends(robot, single) == GripperEnds(-0.2, 2.0)
    named = {"gripper": {"open": {"gripper_joint": 0.0}, "closed": {"gripper_joint": 1.5}}}
    assert gripper_ends(replace(robot, named_states=named), single) == GripperEnds(2.0, -0.2)


@pytest.mark.parametrize(
    ("name", "most"), [("panda", 0.08), ("gen3", 0.085), ("xarm6", 0.087), ("px100", 0.044)]
)
def test_a_width_is_how_far_the_pads_are_apart(name, most):
    robot = load_robot(name)
    (gripper,) = robot.grippers
    ends = gripper_ends(robot, gripper)
    assert width_at(robot, gripper, ends.closed) == 0.0
    assert width_at(robot, gripper, ends.opened) == pytest.approx(most, abs=5e-4)
    for width in (0.01, 0.03):
        position = position_at(robot, gripper, width)
        assert width_at(robot, gripper, position) == pytest.approx(width, abs=1e-6)


def test_an_assumed_state_opens_by_the_pads():
    robot = with_assumed_names(
        replace(load_robot("gen3"), assumes_names=True, named_states={}), lambda _: None
    )
    (gripper,) = robot.grippers
    opened, closed = (
        gripper.position(robot.named_states["gripper"][name]) for name in ("hand_open", "closed")
    )
    assert (opened, closed) == (0.0, 0.8)


@pytest.fixture
def gen3() -> Twin:
    return Twin.build(load_robot("gen3"), load_scene("empty"))


def gripper_position(twin: Twin) -> float:
    return twin.robot.grippers[0].position(twin.joint_state().positions)


def settle(twin: Twin, motion) -> None:
    while motion.outcome == "active":
        twin.advance(twin.time_ns + 100_000_000)


@pytest.mark.parametrize("place", range(4))
def test_a_trajectory_of_one_finger_moves_the_gripper_to_that_fingers_goal(gen3, place):
    gripper = gen3.robot.grippers[0]
    joint = gripper.joints[place]
    goal = np.array([[gripper.sign(joint) * 0.6]])
    motion = gen3.follow(JointTrajectory((joint,), np.array([1.0]), goal, np.zeros((1, 1))))
    assert motion.goal == (0.6,)
    settle(gen3, motion)
    assert gripper_position(gen3) == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize("place", range(4))
def test_what_a_trajectory_says_of_the_other_fingers_does_not_hold_the_gripper_back(gen3, place):
    gripper = gen3.robot.grippers[0]
    ends = np.zeros((2, 4))
    ends[1, place] = gripper.sign(gripper.joints[place]) * 0.6
    motion = gen3.follow(
        JointTrajectory(gripper.joints, np.array([0.0, 1.0]), ends, np.zeros((2, 4)))
    )
    settle(gen3, motion)
    assert gripper_position(gen3) == pytest.approx(0.6, abs=0.01)


@pytest.mark.parametrize("place", range(4))
def test_a_plan_for_one_finger_takes_the_others_along(gen3, place):
    gripper = gen3.robot.grippers[0]
    joint = gripper.joints[place]
    plan = gen3.plan_joints("gripper", {joint: gripper.sign(joint) * 0.5})
    end = dict(zip(plan.joints, plan.position[-1].tolist(), strict=True))
    assert end == {name: gripper.sign(name) * 0.5 for name in gripper.joints}


def test_a_gripper_whose_pads_nobody_names_opens_by_growing():
    robot = load_robot("panda")
    gripper = replace(robot.grippers[0], pads=())
    assert gripper_ends(robot, gripper).opened == gripper.opening
