"""An arm that is sold without a gripper gets one, assumed, where the controller commands one."""

from dataclasses import replace

import pytest

from tracerisk import api
from tracerisk.common import trace_json
from tracerisk.config import Settings
from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.robot.choice import choose_robot
from tracerisk.trace import Trace
from tracerisk.twin.robots.assumed_gripper import (
    commands_gripper,
    has_assumed_gripper,
    with_assumed_gripper,
)
from tracerisk.twin.robots.robot import Controller, Group, Robot, load_robot, robot_names
from tracerisk.twin.urdf.urdf import read_urdf

CONTROLLER = """\
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from control_msgs.msg import GripperCommandAction, GripperCommandGoal
from trajectory_msgs.msg import JointTrajectoryPoint

UR5E = [
    "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
    "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]


def turn():
    arm = actionlib.SimpleActionClient(
        "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction
    )
    arm.wait_for_server()
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = UR5E
    place = [0.3, -1.57, 0.0, -1.57, 0.0, 0.0]
    goal.trajectory.points = [
        JointTrajectoryPoint(positions=place, time_from_start=rospy.Duration(1.0))
    ]
    arm.send_goal_and_wait(goal)


def grip():
    hand = actionlib.SimpleActionClient("/gripper_controller/gripper_cmd", GripperCommandAction)
    hand.wait_for_server()
    goal = GripperCommandGoal()
    goal.command.position = 0.0
    hand.send_goal_and_wait(goal)


rospy.init_node("pick")
turn()
grip()
"""


@pytest.fixture(scope="module")
def trace(tmp_path_factory, example_in) -> Trace:
    example = example_in(tmp_path_factory.mktemp("ur"))
    example.write("pick.py", CONTROLLER)
    outcome = example.run("run", "pick.py", "--json", "--trace", "trace.json")
    assert outcome.code == 0, outcome.err
    assert "name = gripper" in example.read("pick.py").decode()
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


def test_the_gripper_moves_and_is_reported_to_be_assumed(trace):
    moved = {
        visit.function.name: {
            name for name, each in visit.exposures.items() if each and each.moving_s > 0.0
        }
        for visit in trace.visits
    }
    assert moved["grip"] == {"gripper"}
    (turn,) = [visit for visit in trace.visits if visit.function.name == "turn"]
    idle = turn.exposures.get("gripper")
    assert idle is None or idle.active_s == 0.0
    text = " ".join(trace.assumptions)
    assert "the gripper that the controller speaks of is assumed, on 'tool0'" in text
    assert "ur5e are approximate" in text


@pytest.mark.parametrize(
    ("source", "asks"),
    [
        (b"from control_msgs.action import GripperCommand", True),
        (b"NAME = '/robotiq_gripper_controller/gripper_cmd'", True),
        (b"GROUP = 'gripper'", True),
        (b"NAME = '/hand/over'", False),
        (b"SAY = 'the gripper is not here'", False),
        (b"handler = 'handle'", False),
        (b"print 'gripper'", False),
    ],
)
def test_a_gripper_is_asked_for_by_its_names_and_not_in_prose(source: bytes, asks: bool):
    assert commands_gripper(parsed(source)) == asks


def test_a_controller_without_a_gripper_gets_the_arm_as_it_is_sold(tmp_path):
    (tmp_path / "turn.py").write_text(CONTROLLER.partition("def grip")[0].replace("Gripper", ""))
    robot = choose_robot(api.load_controller(tmp_path / "turn.py"), Settings()).robot
    assert robot.name == "ur5e"
    assert robot.grippers == ()
    assert not robot.approximate


BARE = (
    *("a0509", "cr10", "cr3", "cr5", "crx10ia", "gp7", "gp8", "hc10"),
    *("iiwa14", "iiwa14_stack", "iiwa7", "iiwa7_stack", "irb120", "lite6", "lrmate200id"),
    *("m0609", "m1013", "mycobot_320", "nova5", "tm12", "tm5_700", "tm5_900", "tm5_900_tmr"),
    *("ur10", "ur10e", "ur16e", "ur20", "ur3", "ur30", "ur3e", "ur5", "ur5e"),
)
"""The arms without a gripper; to ask each robot while tests are collected takes seconds."""


def test_the_arms_without_a_gripper_are_all_there_are():
    assert tuple(name for name in robot_names() if not load_robot(name).grippers) == BARE


@pytest.mark.parametrize("name", BARE)
def test_every_arm_without_one_takes_it_and_its_hardware_counts_it(name: str):
    from tracerisk.common.hardware.binding import bind
    from tracerisk.common.hardware.shipped import shipped_hardware
    from tracerisk.twin.physics.builder import compile_model

    robot = with_assumed_gripper(load_robot(name), ["robotiq_85_left_knuckle_joint"])
    compile_model(robot)
    assert robot.grippers[0].joints[0] == "robotiq_85_left_knuckle_joint"
    bound = {each.component.name for each in bind(shipped_hardware(name), robot.elements)}
    assert "gripper" in bound
    assert "gripper" not in {
        each.component.name for each in bind(shipped_hardware(name), load_robot(name).elements)
    }


def arm_with(*extra: str) -> Robot:
    """An arm of two joints whose file has further parts."""
    joint = (
        '<link name="{1}"><inertial><mass value="1"/></inertial></link>'
        '<joint name="{0}" type="{2}"><parent link="{3}"/><child link="{1}"/>'
        '<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="20" velocity="2"/></joint>'
    )
    parts = [
        joint.format("turn", "upper", "revolute", "root"),
        joint.format("bend", "lower", "revolute", "upper"),
    ]
    parts += [joint.format(*each.split(), "fixed", "lower") for each in extra]
    return read_urdf(f'<robot name="r"><link name="root"/>{"".join(parts)}</robot>', "r.urdf")


@pytest.mark.parametrize(
    ("extra", "joints"),
    [
        (("gripper_joint mount",), ()),
        (("gripper_joint mount",), ("gripper_joint",)),
        (("gripper_second_finger_joint mount", "gripper_joint plate"), ()),
        (("left_finger_joint assumed_finger_1",), ("left_finger_joint", "right_finger_joint")),
        (("mount assumed_finger_2",), ()),
    ],
)
def test_an_assumed_gripper_takes_no_name_that_the_robot_has(extra, joints):
    from tracerisk.twin.physics.builder import compile_model

    robot = with_assumed_gripper(arm_with(*extra), joints)
    compile_model(robot)
    assert has_assumed_gripper(robot)
    for names in (robot.link_names, [each.name for each in robot.attachments]):
        assert len(set(names)) == len(names)


def test_an_assumed_gripper_leaves_group_and_controller_of_that_name_as_they_are():
    arm = arm_with()
    driver = Controller("gripper_controller", "follow_joint_trajectory", ("bend",))
    group = Group(("bend",), "lower")
    arm = replace(arm, groups={**arm.groups, "gripper": group}, controllers=(driver,))
    robot = with_assumed_gripper(arm, ())
    assert robot.groups["gripper"] == group
    assert robot.controllers[0] == driver
    assert robot.gripper("gripper").group == "assumed_gripper"
