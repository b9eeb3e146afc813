"""A grasp, a miss, a slip and a release by a gripper of each kind, and what the verdict says of it.

What is grasped stands below the open hand, on a post through which the robot passes.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from tests.slow import slow_but
from tracerisk.common.geometry.frames import rotation
from tracerisk.twin.motion.gripper_track import FINGER_LENGTH_M
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.gripper_ends import gripper_ends, pad_centres, width_at
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Gripper

KINDS = {
    "panda": ("panda_arm", "ready"),
    "gen3": ("manipulator", "Home"),
    "px100": ("interbotix_arm", "Home"),
    "xarm6": ("xarm6", "hold-up"),
}
"""Fingers that slide or turn, that open or close by growing, of one sign or two, each with a named
state in which the hand is level."""
TOO_HEAVY = {"px100": (0.15, 6.5)}
"""With which share of its effort a gripper presses on what slips out of it, and how heavy that is by
what it could press with; both as small as the arm can still move."""
LOWER_M = 0.08
"""How far the hand comes down to what it grasps [m]."""
EFFORT = 0.1
"""With which share of its effort a gripper presses."""

CONTROLLER = """\
import actionlib
import rospy
from control_msgs.msg import (
    FollowJointTrajectoryAction, FollowJointTrajectoryGoal, GripperCommandAction,
    GripperCommandGoal)
from trajectory_msgs.msg import JointTrajectoryPoint

def move(positions):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = {joints}
    point = JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(2.0))
    goal.trajectory.points = [point]
    arm.send_goal_and_wait(goal)

def grip(position, effort):
    goal = GripperCommandGoal()
    goal.command.position, goal.command.max_effort = position, effort
    hand.send_goal_and_wait(goal)

def take():
    grip({closed}, {effort})

def lift():
    move({above})

def lower():
    move({below})

def release():
    grip({opened}, 0.0)

rospy.init_node("c")
arm = actionlib.SimpleActionClient("/arm/follow_joint_trajectory", FollowJointTrajectoryAction)
hand = actionlib.SimpleActionClient("/hand/gripper_cmd", GripperCommandAction)
arm.wait_for_server()
hand.wait_for_server()
release()
lift()
lower()
take()
lift()
"""


@dataclass(frozen=True)
class Cell:
    """A robot, and a box below its hand."""

    robot: Robot

    @property
    def gripper(self) -> Gripper:
        return self.robot.grippers[0]

    @property
    def above(self) -> dict[str, float]:
        """Where the open hand is clear of the box."""
        opened = gripper_ends(self.robot, self.gripper).opened
        fingers = {name: self.gripper.sign(name) * opened for name in self.gripper.joints}
        group, state = KINDS[self.robot.name]
        posture = self.robot.named_states[group][state]
        return {**self.robot.initial_state, **posture, **fingers}

    @property
    def below(self) -> dict[str, float]:
        """Where the hand is lower, by the joint that lowers it most."""
        start = self.above
        names = [each.name for each in self.robot.arm_joints]
        lowering = max(names, key=lambda name: abs(self.height(name, 0.01) - self.height(name, 0)))
        step = math.copysign(0.005, self.height(lowering, 0) - self.height(lowering, 0.01))
        wanted = self.height(lowering, 0) - LOWER_M
        count = next(n for n in range(1, 200) if self.height(lowering, n * step) < wanted)
        return {**start, lowering: start[lowering] + count * step}

    def height(self, joint: str, by: float) -> float:
        at = {**self.above, joint: self.above[joint] + by}
        return float(np.mean(self.pads(at), axis=0)[2])

    @property
    def too_heavy(self) -> tuple[float, float]:
        return TOO_HEAVY.get(self.robot.name, (0.08, 3.5))

    def pads(self, at: dict[str, float]) -> list[np.ndarray]:
        stage = load_scene("empty")
        turn = rotation(stage.robot_rpy)
        return [turn @ pad + stage.robot_xyz for pad in pad_centres(self.robot, self.gripper, at)]

    def scene(self, *, heavy: bool, aside_m: float) -> str:
        first, *others = self.pads(self.below)
        x, y, z = np.mean([first, *others], axis=0)
        across = first - np.mean(others, axis=0)
        thick = 0.5 * width_at(self.robot, self.gripper, self.above[self.gripper.joints[0]])
        is_sliding = self.robot.joint(self.gripper.joints[0]).type == "prismatic"
        force = EFFORT * self.gripper.effort / (1.0 if is_sliding else FINGER_LENGTH_M)
        mass = force * (self.too_heavy[1] if heavy else 0.2) / 9.81
        low = z - 0.03
        return f"""\
name: post
title: A box on a post
fixtures:
  - name: post
    meets_robot: false
    shapes: [{{kind: box, size: [0.03, 0.03, 0.01], xyz: [{x + aside_m}, {y}, {low - 0.01}]}}]
  - name: floor
    meets_robot: false
    shapes: [{{kind: box, size: [2.0, 2.0, 0.1], xyz: [0.0, 0.0, {low - 0.4}]}}]
objects:
  - name: cargo
    xyz: [{x + aside_m}, {y}, {low + 0.025}]
    rpy: [0.0, 0.0, {math.atan2(across[1], across[0])}]
    mass: {mass}
    shapes: [{{kind: box, size: [{thick / 2}, 0.012, 0.025]}}]
"""

    def controller(self, *, weak: bool) -> str:
        ends = gripper_ends(self.robot, self.gripper)
        joints = [each.name for each in self.robot.arm_joints]
        return CONTROLLER.format(
            joints=joints,
            closed=ends.closed,
            opened=ends.opened,
            effort=(self.too_heavy[0] if weak else EFFORT) * self.gripper.effort,
            above=[self.above[name] for name in joints],
            below=[self.below[name] for name in joints],
        )


@dataclass(frozen=True)
class Fate:
    """What a controller does once it has lifted the box, and what becomes of it."""

    calls: str
    codes: tuple[str, ...]
    heavy: bool = False
    aside_m: float = 0.0


FATES = {
    "released": Fate("lower(); release(); lift()", ()),
    "missed": Fate("lower(); release(); lift()", ("grasped-nothing",), aside_m=0.15),
    "slipped": Fate("release()", ("object-slipped",), heavy=True),
    "dropped": Fate("release()", ("object-dropped",)),
    "kept": Fate("", ()),
}
QUICK = [("gen3", "released"), ("gen3", "missed"), ("panda", "slipped")]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("robot", "fate"), slow_but(QUICK, [(robot, fate) for robot in KINDS for fate in FATES])
)
def test_the_verdict_says_what_became_of_a_grasp(tmp_path, example_in, robot, fate):
    cell, becomes = Cell(load_robot(robot)), FATES[fate]
    example = example_in(tmp_path)
    example.write("c.py", f"{cell.controller(weak=becomes.heavy)}{becomes.calls}\n")
    example.write("post.yaml", cell.scene(heavy=becomes.heavy, aside_m=becomes.aside_m))
    outcome = example.run("run", "c.py", "--json", "--robot", robot, "--scene", "post.yaml")
    reasons = outcome.json["trace"]["verdict"]["reasons"]
    codes = tuple(each["code"] for each in reasons if each["code"] != "never-ran")
    assert codes == becomes.codes, [each["words"] for each in reasons]
