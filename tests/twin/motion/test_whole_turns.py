"""Pose goals take the nearest solution of the inverse kinematics, whole turns included."""

import math

import numpy as np
import pytest

from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.kinematics import Kinematics, turned_near
from tracerisk.twin.motion.planning import Planner
from tracerisk.twin.physics.motion import LinkTarget, PlanningError, Pose
from tracerisk.twin.robots.robot import load_robot

DOWN = (1.0, 0.0, 0.0, 0.0)
READY = (0.0, -1.57, 1.57, -1.57, -1.57, 0.0)
CHAIN = ((0.45, -0.3, 0.2), (0.35, 0.3, 0.3), (0.5, 0.1, 0.15), (0.4, -0.2, 0.35), (-0.4, 0.1, 0.3))


class Arm:
    """An arm of which pose goals are asked, one after the other."""

    def __init__(self, name: str, group: str, positions) -> None:
        self.robot, self.group = load_robot(name), group
        self.kinematics = Kinematics(self.robot)
        self.names = self.robot.group(group).joints
        self.tip = self.robot.group(group).tip_link
        self.state = {**self.robot.initial_state, **dict(zip(self.names, positions, strict=True))}

    def values(self, found) -> np.ndarray:
        return np.array([found[name] for name in self.names])

    def pose(self, **changed: float) -> Pose:
        return self.kinematics.forward({**self.state, **changed}, self.tip)

    def solutions(self, pose: Pose) -> list[np.ndarray]:
        found = self.kinematics.solutions(self.group, [LinkTarget(self.tip, pose)], seed=self.state)
        return [self.values(each) for each in found]


@pytest.mark.parametrize(
    ("name", "group"),
    [("ur10e", "ur_manipulator"), ("ur5e", "manipulator"), ("m1013", "manipulator")],
)
def test_a_chain_of_goals_takes_no_needless_turn(name, group):
    arm = Arm(name, group, READY if name != "m1013" else (0.0, 0.0, 1.57, 0.0, 1.57, 0.0))
    for place in CHAIN:
        before = arm.values(arm.state)
        arm.state.update(arm.kinematics.inverse(group, Pose(place, DOWN), seed=arm.state))
        for joint, here, there in zip(arm.names, before, arm.values(arm.state), strict=True):
            limits = arm.robot.joint(joint)
            other = there - math.copysign(2 * math.pi, there - here)
            is_possible = limits.lower <= other <= limits.upper
            assert not (is_possible and abs(other - here) < abs(there - here) - 1e-6), joint


def test_the_elbow_up_solution_is_taken_where_it_is_nearest():
    arm = Arm("ur10e", "ur_manipulator", READY)
    found = arm.kinematics.inverse("ur_manipulator", Pose((0.45, -0.3, 0.2), DOWN), seed=arm.state)
    assert found["shoulder_pan_joint"] == pytest.approx(-0.916, abs=1e-3), "not 5.367"
    assert np.abs(arm.values(found) - READY).max() < 2.6


@pytest.mark.parametrize("name", ["ur10e", "xarm6"])
def test_no_descent_from_anywhere_finds_a_nearer_solution(name):
    group = "ur_manipulator" if name == "ur10e" else name
    arm = Arm(name, group, READY if name == "ur10e" else (0.0, 0.0, -1.57, 0.0, 1.57, 0.0))
    generator = np.random.default_rng(3)
    here = arm.values(arm.state)
    for place in ((-0.3, 0.25, 0.2), (0.2, -0.4, 0.15)):
        pose = Pose(place, DOWN)
        nearest = np.linalg.norm(arm.solutions(pose)[0] - here)
        for _ in range(25):
            start = dict(zip(arm.names, generator.uniform(-2.0, 2.0, len(here)), strict=True))
            try:
                other = arm.kinematics.inverse(group, pose, seed=start, restarts=0)
            except PlanningError:
                continue
            apart = arm.values(other) - here
            apart -= 2 * math.pi * np.round(apart / (2 * math.pi))
            assert nearest <= np.linalg.norm(apart) + 1e-3


def test_solutions_come_nearest_first_and_each_once():
    arm = Arm("ur5e", "manipulator", READY)
    pose = Pose((0.3, 0.3, 0.3), DOWN)
    found = arm.solutions(pose)
    assert len(found) == 8, "shoulder left or right, elbow up or down, wrist flipped or not"
    far = [float(np.linalg.norm(each - arm.values(arm.state))) for each in found]
    assert far == pytest.approx(sorted(far), abs=1e-3)
    for each in found:
        there = arm.pose(**dict(zip(arm.names, each.tolist(), strict=True)))
        assert there.position == pytest.approx(pose.position, abs=2e-4)
    apart = [np.abs(a - b).max() for i, a in enumerate(found) for b in found[:i]]
    assert min(apart) > 0.1


def test_a_joint_at_the_end_of_its_range_turns_back_within_its_limits():
    arm = Arm("ur5e", "manipulator", (6.0, *READY[1:]))
    beyond = arm.pose(shoulder_pan_joint=6.0 + 0.5)
    for found in arm.solutions(beyond):
        assert np.abs(found).max() <= 2 * math.pi + 1e-9
    back = arm.pose(shoulder_pan_joint=5.5)
    assert arm.solutions(back)[0][0] == pytest.approx(5.5, abs=1e-2), "no whole turn where it is"


def test_a_joint_that_has_turned_once_stays_there():
    arm = Arm("ur10e", "manipulator", (*READY[:5], 2 * math.pi - 0.3))
    found = arm.solutions(arm.pose(shoulder_pan_joint=1.5, wrist_3_joint=2 * math.pi - 0.5))
    assert found[0][5] == pytest.approx(2 * math.pi - 0.5, abs=0.3)


@pytest.mark.parametrize(
    ("value", "near", "within", "wanted"),
    [
        (1.0, 6.0, (-6.3, 6.3), 1.0),
        (1.0, -4.0, (-6.3, 6.3), 1.0 - 2 * math.pi),
        (1.0, 9.0, (-math.inf, math.inf), 1.0 + 2 * math.pi),
        (6.4, 6.2, (0.1, 0.2), 6.4 - 2 * math.pi),
        (3.0, 3.0, (-2.0, 2.0), 2.0),
        (-2.5, 0.0, (-2.0, 2.0), -2.0),
    ],
)
def test_the_turn_nearest_to_a_joint_is_within_its_bounds(value, near, within, wanted):
    joint = load_robot("gen3").joint("joint_1")
    assert turned_near(joint, value, near, within) == pytest.approx(wanted)


def test_an_arm_without_a_second_turn_keeps_to_the_descent_from_where_it_is():
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    ready = {**robot.initial_state, **robot.named_states["panda_arm"]["ready"]}
    pose = Pose((0.3, -0.5, 0.4), DOWN)
    first = kinematics.inverse("panda_arm", pose, seed=ready, restarts=0)
    assert kinematics.inverse("panda_arm", pose, seed=ready) == first


def test_the_same_goal_has_the_same_solutions_whatever_was_asked_before():
    arm = Arm("xarm6", "xarm6", (0.0, 0.0, -1.57, 0.0, 1.57, 0.0))
    pose = Pose((-0.2, -0.3, 0.2), DOWN)
    first = arm.solutions(pose)
    arm.solutions(Pose((0.3, 0.2, 0.3), DOWN))
    again = arm.solutions(pose)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


@pytest.mark.parametrize(("asked", "reached"), [(7.0, 7.0), (5.5, 5.5), (0.2, 6.2 + 0.2831853)])
def test_a_joint_without_stops_goes_the_short_way_to_a_joint_goal(asked, reached):
    robot = load_robot("gen3")
    planner = Planner(robot, Kinematics(robot), Clearance(robot))
    start = {**robot.initial_state, "joint_1": 6.2}
    plan = planner.joints("manipulator", {"joint_1": asked}, start)
    assert plan.position[-1][plan.joints.index("joint_1")] == pytest.approx(reached, abs=1e-6)


def test_a_cartesian_path_goes_on_where_the_range_of_a_joint_without_stops_ends():
    robot = load_robot("gen3")
    kinematics = Kinematics(robot)
    planner = Planner(robot, kinematics, Clearance(robot))
    bent = {"joint_2": 0.5, "joint_4": 1.8, "joint_6": 0.8}
    start = {**robot.initial_state, **bent, "joint_1": 2 * math.pi - 0.05}
    goal = kinematics.forward({**start, "joint_1": 2 * math.pi + 0.1}, "end_effector_link")
    plan, fraction = planner.cartesian("manipulator", [goal], start, eef_step=0.02)
    assert fraction == 1.0
    assert np.abs(np.diff(plan.position, axis=0)).max() < 0.3
    assert plan.position[-1][0] > 2 * math.pi
