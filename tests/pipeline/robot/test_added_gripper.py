"""An arm that is sold without a gripper gets one: a shipped one that is named, or an assumed one."""

from dataclasses import replace

import pytest

from tracerisk import api
from tracerisk.common import trace_json
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.config import Settings
from tracerisk.errors import RobotError
from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.robot.choice import choose_robot
from tracerisk.trace import Trace
from tracerisk.twin.robots.added_gripper import (
    commands_gripper,
    has_assumed_gripper,
    named_robot,
    with_assumed_gripper,
)
from tracerisk.twin.robots.gripper_ends import gripper_ends, width_at
from tracerisk.twin.robots.index import shipped_grippers
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Controller, Group
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
    (reason,) = [one for one in trace.verdict.reasons if one.object == "gripper"]
    assert f"--robot ur5e+GRIPPER names it, one of {', '.join(shipped_grippers())}" in reason.words


@pytest.mark.parametrize(
    ("source", "asks"),
    [
        (b"from control_msgs.action import GripperCommand", True),
        (b"NAME = '/robotiq_gripper_controller/gripper_cmd'", True),
        (b"GROUP = 'gripper'", True),
        (b"NAME = '/hand/over'", False),
        (b"SAY = 'the gripper is not here'", False),
        (b"handler = 'handle'", False),
        (b"GROUP = = 'gripper'", False),
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


NAMED = "ur5e+robotiq_2f_85"


@pytest.fixture(scope="module")
def gripped(tmp_path_factory):
    """The trace of a controller of an UR5e with a Robotiq 2F-85 that uses its driver's joint."""
    script = tmp_path_factory.mktemp("press") / "press.py"
    closing = CONTROLLER.replace("position = 0.0", "position = 0.62")
    script.write_text(f"FINGER = 'finger_joint'\n{closing}")
    controller = api.load_controller(script)
    return api.trace_controller(controller, controller.settings_with({"robot": NAMED}))


def test_an_arm_with_a_named_gripper_is_nothing_that_is_assumed(gripped):
    assert gripped.robot == NAMED
    assert gripped.verdict.kind == "complete", gripped.verdict.reasons
    (grip,) = [one for one in gripped.commands if one.elements == ("robotiq_2f_85",)]
    assert grip.end == "arrived"
    assert "robot: robotiq_2f_85 is on tool0 as gen3 bears it" in "\n".join(gripped.assumptions)


@pytest.mark.parametrize(
    ("said", "joint"),
    [("finger_joint", "finger_joint"), ("wheel_joint", "robotiq_85_left_knuckle_joint")],
)
def test_the_joint_of_the_driver_is_that_of_the_gripper(tmp_path, said, joint):
    (tmp_path / "press.py").write_text(f"JOINTS = [{said!r}]\n{CONTROLLER}")
    controller = api.load_controller(tmp_path / "press.py")
    robot = choose_robot(controller, Settings(robot=NAMED)).robot
    assert robot.grippers[0].joints[0] == joint
    assert robot.joint(joint).upper == 0.8


@pytest.mark.parametrize(
    ("said", "gripper"),
    [("robotiq_85_left_knuckle_joint", "robotiq_2f_85"), ("left_knuckle_joint", "gripper")],
)
def test_a_gripper_whose_joint_is_named_is_that_one(tmp_path, said, gripper):
    (tmp_path / "press.py").write_text(f"JOINTS = [{said!r}]\n{CONTROLLER}")
    robot = choose_robot(api.load_controller(tmp_path / "press.py"), Settings()).robot
    assert [one.name for one in robot.grippers] == [gripper]
    assert robot.grippers[0].joints[0] == said
    assert has_assumed_gripper(robot) == (gripper == "gripper")


@pytest.mark.parametrize("name", shipped_grippers())
def test_each_gripper_fits_an_arm_and_is_as_wide_as_on_its_own(name):
    robot, own = named_robot(f"ur5e+{name}"), load_robot(shipped_grippers()[name])
    (gripper,) = robot.grippers
    (theirs,) = [one for one in own.grippers if one.name == name]
    ends = gripper_ends(robot, gripper)
    assert ends == gripper_ends(own, theirs)
    assert width_at(robot, gripper, ends.opened) == pytest.approx(
        width_at(own, theirs, ends.opened), abs=1e-9
    )
    # Each part hangs on the arm, and the arm has its joints as before.
    assert all("tool0" in [up.parent for up in robot.above(pad)] for pad in gripper.pads)
    borne = {link.name for link in own.links if link.mass > 0.0} & {
        link.name for link in robot.links
    }
    assert any("base" in link or "hand" in link for link in borne)
    assert [one.name for one in robot.arm_joints] == [
        one.name for one in load_robot("ur5e").arm_joints
    ]
    assert hardware_of(robot.name) == hardware_of("ur5e")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("ur5e+robotiq", r"unknown gripper 'robotiq'; did you mean 'robotiq_2f_85'\?"),
        ("panda+robotiq_2f_85", "panda has the gripper panda_hand already"),
        ("ur55e+robotiq_2f_85", "unknown robot 'ur55e'"),
    ],
)
def test_what_is_no_arm_with_a_gripper_is_refused(name, words):
    with pytest.raises(RobotError, match=words):
        named_robot(name)
