"""What the verdict makes of grippers, whichever way their joints turn."""

from __future__ import annotations

import pytest

from tests.slow import slow_but

KNUCKLE = "robotiq_85_left_knuckle_joint"
ENDS = {
    "panda": ("panda_arm", "hand", [0.035, 0.035], [0.0, 0.0]),
    "gen3": ("manipulator", "gripper", {KNUCKLE: 0.0}, {KNUCKLE: 0.75}),
    "xarm6": ("xarm6", "xarm_gripper", {"drive_joint": 0.0}, {"drive_joint": 0.8}),
    "j2n6s300": ("arm", "gripper", [0.2] * 3, [1.3] * 3),
}
CLOSES_TWICE = """\
import sys
import moveit_commander
import rospy

def turn(angle):
    goal = arm.get_current_joint_values()
    goal[0] += angle
    arm.go(goal, wait=True)

def close():
    hand.go({closed}, wait=True)

def release():
    hand.go({opened}, wait=True)

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("c")
arm = moveit_commander.MoveGroupCommander("{arm}")
hand = moveit_commander.MoveGroupCommander("{hand}")
release()
for side in (0.3, -0.3):
    turn(side)
    close()
    turn(0.2)
    release()
"""
ASIDE = """\
objects:
  - {name: cube, box: [0.04, 0.04, 0.04], xyz: [0.9, -0.6, 0.02], mass: 0.1}
"""


@pytest.mark.parametrize(
    "robot",
    slow_but(["panda", "gen3"], [*ENDS]),
)
def test_a_gripper_that_closes_on_nothing_is_told_at_the_line_that_closes_it(
    tmp_path, example_in, robot
):
    arm, hand, opened, closed = ENDS[robot]
    example = example_in(tmp_path)
    example.write("c.py", CLOSES_TWICE.format(arm=arm, hand=hand, opened=opened, closed=closed))
    example.write("cell.yaml", ASIDE)
    outcome = example.run("run", "c.py", "--json", "--robot", robot, "--scenario", "cell.yaml")
    reasons = outcome.json["trace"]["verdict"]["reasons"]
    assert [(each["code"], each["function"]) for each in reasons] == [("grasped-nothing", "close")]
