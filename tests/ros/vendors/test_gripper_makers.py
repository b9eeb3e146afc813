"""Grippers of makers on any arm, and ROBOTIS's OpenManipulator, by their own messages."""

import pytest

TWO_FINGERS = """
from robotiq_2f_gripper_control.msg import _Robotiq2FGripper_robot_output as messages
Output, topic = messages.Robotiq2FGripper_robot_output, 'Robotiq2FGripperRobotOutput'
"""
C_MODEL = """
from robotiq_msgs.msg import CModelCommand as Output
topic = '/gripper/CModelRobotOutput'
"""
THREE_FINGERS = """
from robotiq_3f_gripper_articulated_msgs.msg import Robotiq3FGripperRobotOutput as Output
topic = 'Robotiq3FGripperRobotOutput'
"""
ROBOTIQ = """
import rospy
rospy.init_node('gripper')
commands = rospy.Publisher(topic, Output, queue_size=1)
rospy.sleep(0.5)
def ask(**fields):
    asked = Output(rACT=1, rGTO=1)
    for name, value in fields.items():
        setattr(asked, name, value)
    commands.publish(asked)
    rospy.sleep(1.5)
ask(rACT=0)
ask(FIELD=0)
ask(FIELD=255)
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("messages", "field"), [(TWO_FINGERS, "rPR"), (C_MODEL, "rPR"), (THREE_FINGERS, "rPRA")]
)
def test_a_robotiq_gripper_opens_and_closes(run_on, messages, field):
    ran = run_on("panda", messages + ROBOTIQ.replace("FIELD", field))
    assert len(ran.commands) == 2
    assert ran.position("panda_finger_joint1") == pytest.approx(0.0, abs=0.002)


def test_a_robotiq_gripper_reports_where_it_is(run_on):
    ran = run_on(
        "panda",
        f"""{TWO_FINGERS}
import rospy
from robotiq_2f_gripper_control.msg import Robotiq2FGripper_robot_input as Input
rospy.init_node('gripper')
commands = rospy.Publisher(topic, Output, queue_size=1)
rospy.sleep(0.5)
commands.publish(Output(1, 1, 0, 128, 255, 150))
rospy.sleep(2.0)
state = rospy.wait_for_message('Robotiq2FGripperRobotInput', Input)
""",
    )
    assert (ran["state"].gACT, ran["state"].gOBJ) == (1, 3)
    assert ran["state"].gPO == pytest.approx(128, abs=4)


def test_an_onrobot_gripper_takes_widths_and_letters(run_on):
    ran = run_on(
        "panda",
        """
import rospy
from onrobot_rg_control.msg import OnRobotRGInput, OnRobotRGOutput
from onrobot_rg_control.srv import SetCommand
rospy.init_node('gripper')
commands = rospy.Publisher('OnRobotRGOutput', OnRobotRGOutput, queue_size=1)
rospy.sleep(0.5)
commands.publish(OnRobotRGOutput(rGFR=400, rGWD=550, rCTR=16))
rospy.sleep(1.5)
width = rospy.wait_for_message('OnRobotRGInput', OnRobotRGInput).gGWD
rospy.ServiceProxy('/onrobot_rg/set_command', SetCommand)('c')
""",
    )
    assert ran["width"] == pytest.approx(550, abs=15)
    assert len(ran.commands) == 2
    assert ran.position("panda_finger_joint1") == pytest.approx(0.0, abs=0.002)


def test_a_wsg_takes_widths_in_millimetres(run_on):
    ran = run_on(
        "panda",
        """
import rospy
from std_srvs.srv import Empty
from wsg_50_common.srv import Conf, Move
rospy.init_node('gripper')
rospy.ServiceProxy('/wsg_50_driver/homing', Empty)()
rospy.ServiceProxy('/wsg_50_driver/set_force', Conf)(40.0)
error = rospy.ServiceProxy('/wsg_50_driver/move', Move)(30.0, 100.0).error
""",
    )
    assert ran["error"] == 0
    assert ran.position("panda_finger_joint1") == pytest.approx(0.015, abs=0.001)


def test_an_open_manipulator_takes_its_services(run_on):
    ran = run_on(
        "open_manipulator_x",
        """
import rospy
from open_manipulator_msgs.srv import *
rospy.init_node('task')
names = ['joint1', 'joint2', 'joint3', 'joint4']
def joints(name, positions, seconds, of=names):
    asked = SetJointPositionRequest(path_time=seconds)
    asked.joint_position.joint_name, asked.joint_position.position = of, positions
    return rospy.ServiceProxy(name, SetJointPosition)(asked).is_planned
planned = [joints('goal_joint_space_path', [0.2, -0.5, 0.3, 0.4], 2.0)]
begun = rospy.get_time()
rospy.sleep(2.2)
planned.append(joints('goal_joint_space_path_from_present', [0.1, 0.0, 0.0, 0.0], 1.0))
rospy.sleep(1.2)
planned.append(joints('/goal_tool_control', [0.01], 1.0, ['gripper']))
rospy.sleep(1.2)
pose = SetKinematicsPoseRequest(end_effector_name='gripper', path_time=2.0)
pose.kinematics_pose.pose.position.x = 0.2
pose.kinematics_pose.pose.position.z = 0.15
pose.kinematics_pose.pose.orientation.w = 1.0
name = 'goal_joint_space_path_to_kinematics_pose'
planned.append(rospy.ServiceProxy(name, SetKinematicsPose)(pose).is_planned)
rospy.sleep(2.2)
""",
    )
    assert ran["planned"] == [True] * 4
    assert len(ran.commands) == 4
    assert ran.position("joint1") == pytest.approx(0.0, abs=0.02)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("names", "positions"),
    [
        (["joint1", "joint2", "joint3", "joint4", "gripper"], [0.2, -0.5, 0.3, 0.4, 0.01]),
        (["joint1", "joint2", "joint3", "joint4", "grip", "sub"], [0.2, -0.5, 0.3, 0.4, 0.1, 0.1]),
        (["a", "b", "c", "d"], [0.2, -0.5, 0.3, 0.4]),
        ([], [0.2, -0.5, 0.3, 0.4]),
    ],
    ids=["gripper", "two more", "other names", "no names"],
)
def test_an_open_manipulator_takes_its_joints_in_their_order(run_on, names, positions):
    ran = run_on(
        "open_manipulator_x",
        f"""
import rospy
from open_manipulator_msgs.srv import *
rospy.init_node('task')
asked = SetJointPositionRequest(path_time=1.0)
asked.joint_position.joint_name, asked.joint_position.position = {names}, {positions}
planned = rospy.ServiceProxy('goal_joint_space_path', SetJointPosition)(asked).is_planned
rospy.sleep(1.5)
""",
    )
    assert ran["planned"]
    found = [ran.position(f"joint{number}") for number in range(1, 5)]
    assert found == pytest.approx([0.2, -0.5, 0.3, 0.4], abs=0.02)


@pytest.mark.parametrize(
    "name", ["goal_task_space_path_position_only", "goal_joint_space_path_to_kinematics_position"]
)
def test_an_open_manipulator_goes_to_a_position_alone_and_says_where_its_tool_is(run_on, name):
    ran = run_on(
        "open_manipulator_x",
        f"""
import rospy
from open_manipulator_msgs.msg import KinematicsPose
from open_manipulator_msgs.srv import *
rospy.init_node('task')
def tool():
    place = rospy.wait_for_message('gripper/kinematics_pose', KinematicsPose).pose.position
    return [place.x, place.y, place.z]
asked = SetKinematicsPoseRequest(end_effector_name='gripper', path_time=2.0)
goal = asked.kinematics_pose.pose.position
goal.x, goal.y, goal.z = 0.155, 0.180, 0.203
planned = rospy.ServiceProxy('{name}', SetKinematicsPose)(asked).is_planned
rospy.sleep(2.5)
tool = tool()
""",
    )
    assert ran["planned"]
    assert ran["tool"] == pytest.approx([0.155, 0.180, 0.203], abs=0.01)
