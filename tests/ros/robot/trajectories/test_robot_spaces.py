"""A controller that drives two arms is never taken for one that drives the single arm it has."""

from dataclasses import replace
from pathlib import Path

import pytest

from tracerisk import api
from tracerisk.config import Settings
from tracerisk.ros.robot.trajectories.robot_spaces import arms_spoken_of, group_of_side
from tracerisk.twin.robots.robot import load_robot

TWO_ARMS = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("two")
JOINTS = ["panda_joint%d" % number for number in range(1, 8)]
for name in {names}:
    publisher = rospy.Publisher(name, JointTrajectory, queue_size=1, latch=True)
    rospy.sleep(1.0)
    message = JointTrajectory(joint_names=JOINTS)
    message.points.append(JointTrajectoryPoint(
        positions=[0.1, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8], time_from_start=rospy.Duration(1.0)))
    publisher.publish(message)
    rospy.sleep(2.0)
"""


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("/left_arm_controller/command", "/right_arm_controller/command"), True),
        (("/arm_1/goal", "/arm_2/goal"), True),
        (("/panda_1/joint_states", "/panda_2/joint_states"), True),
        (("/joint1_controller/command", "/joint2_controller/command"), False),
        (("/arm_1_joint/command", "/arm_2_joint/command"), False),
        (
            ("/arm1_joint_position_controller/command", "/arm2_joint_position_controller/command"),
            False,
        ),
        (("/arm_1_joint_states", "/arm_2_joint_states"), True),
        (("/left/controlled_pose", "/right/controlled_pose"), True),
        (("/left_led/set", "/right_led/set"), False),
        (("/left_gripper/command", "/right_gripper/command"), False),
        (("/left_camera/image_raw", "/right_camera/image_raw"), False),
        (("/bright/goal", "/left/goal"), False),
        (("/left/goal", "/left/goal"), False),
        (("/left/pose", "/right/twist"), False),
    ],
)
def test_names_that_differ_in_the_arm_alone_are_those_of_two_arms(names, expected):
    assert (arms_spoken_of(names) is not None) == expected


@pytest.mark.parametrize(
    ("robot", "name", "group"),
    [
        ("baxter", "/left_driver/goal", "left_arm"),
        ("baxter", "/right/goal", "right_arm"),
        ("baxter", "/driver/goal", None),
        ("panda", "/left_driver/goal", None),
    ],
)
def test_the_side_in_a_name_means_the_arm_of_that_side(robot, name, group):
    assert group_of_side(load_robot(robot), name) == group


@pytest.mark.parametrize(
    ("joint", "group"),
    [("arm_{side}_{number}_joint", "{side}"), ("rob{letter}_{number}", "{side}_arm")],
)
def test_the_arm_of_a_side_is_known_by_its_joints_or_its_own_name(joint, group):
    robot = load_robot("baxter")
    called = {
        known.name: joint.format(side=side, letter=side[0], number=known.name[-2:])
        for known in robot.joints
        for side in ("left", "right")
        if known.name.startswith(f"{side}_")
    }
    joints = [replace(one, name=called.get(one.name, one.name)) for one in robot.joints]
    groups = {
        name if name == "both_arms" else group.format(side=name.partition("_")[0]): replace(
            known, joints=tuple(called.get(one, one) for one in known.joints)
        )
        for name, known in robot.groups.items()
        if name.endswith(("_arm", "_arms"))
    }
    renamed = replace(robot, joints=tuple(joints), groups=groups)
    for side in ("left", "right"):
        assert group_of_side(renamed, f"/{side}/goal") == group.format(side=side)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("sides", [("left", "right"), ("left", "left")])
def test_one_arm_that_stands_for_two_is_an_assumption(tmp_path: Path, sides: tuple[str, ...]):
    script = tmp_path / "go.py"
    script.write_text(TWO_ARMS.format(names=[f"/{side}_arm_controller/command" for side in sides]))
    settings = Settings(robot="panda", draft=False)
    verdict = api.trace_controller(api.load_controller(script), settings).verdict
    assert verdict is not None
    told = [one.words for one in verdict.reasons if one.code == "robot-assumed"]
    expected = ["the controller speaks to two arms"] * (len(set(sides)) - 1)
    assert [words[:33] for words in told] == [words[:33] for words in expected]
    assert verdict.kind == ("partial" if expected else "complete")
