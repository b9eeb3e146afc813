"""The topics, actions and services of iiwa_stack, which is described as data."""

import pytest


def test_joints_are_commanded_and_read_by_topics(run_on):
    ran = run_on(
        "iiwa7_stack",
        """
import rospy
from geometry_msgs.msg import PoseStamped
from iiwa_msgs.msg import JointPosition, CartesianPose
rospy.init_node('stream')
state = []
rospy.Subscriber('/iiwa/state/JointPosition', JointPosition, state.append)
command = rospy.Publisher('/iiwa/command/JointPosition', JointPosition, queue_size=1)
goal = JointPosition()
goal.position.a2, goal.position.a4, goal.position.a6 = 0.3, -1.2, 0.6
rospy.sleep(0.5)
command.publish(goal)
rospy.sleep(4.0)
reached = [getattr(state[-1].position, f'a{n}') for n in range(1, 8)]
pose = rospy.wait_for_message('/iiwa/state/CartesianPose', CartesianPose).poseStamped.pose
line = rospy.Publisher('/iiwa/command/CartesianPoseLin', PoseStamped, queue_size=1)
rospy.sleep(0.5)
target = PoseStamped()
target.header.frame_id = 'iiwa_link_0'
target.pose = pose
target.pose.position.z -= 0.05
before = pose.position.z + 0.05
line.publish(target)
rospy.sleep(4.0)
after = rospy.wait_for_message('/iiwa/state/CartesianPose', CartesianPose)
after = after.poseStamped.pose.position.z
""",
    )
    assert ran["reached"] == pytest.approx([0.0, 0.3, 0.0, -1.2, 0.0, 0.6, 0.0], abs=2e-3)
    assert ran["after"] == pytest.approx(ran["before"] - 0.05, abs=1e-3)


def test_actions_and_limits_are_answered(run_on):
    ran = run_on(
        "iiwa7_stack",
        """
import actionlib
import rospy
from iiwa_msgs.msg import MoveToJointPositionAction, MoveToJointPositionGoal
from iiwa_msgs.srv import SetSmartServoJointSpeedLimits, TimeToDestination
rospy.init_node('move')
limits = rospy.ServiceProxy(
    '/iiwa/configuration/setSmartServoLimits', SetSmartServoJointSpeedLimits)
is_set = limits(joint_relative_velocity=0.2).success
client = actionlib.SimpleActionClient(
    '/iiwa/action/move_to_joint_position', MoveToJointPositionAction)
client.wait_for_server()
goal = MoveToJointPositionGoal()
goal.joint_position.position.a1 = 0.4
client.send_goal_and_wait(goal)
result = client.get_result()
left = rospy.ServiceProxy('/iiwa/state/timeToDestination', TimeToDestination)().remaining_time
""",
    )
    assert ran["is_set"]
    assert ran["result"].success
    assert ran["left"] == 0.0
    assert ran.position("iiwa_joint_1") == pytest.approx(0.4, abs=2e-3)


def test_who_imports_its_messages_and_names_no_robot_drives_an_iiwa(example):
    example.write(
        "cell.py",
        "import rospy\nfrom iiwa_msgs.msg import JointPosition\n\nrospy.init_node('cell')\n"
        "command = rospy.Publisher('/iiwa/command/JointPosition', JointPosition, queue_size=1)\n"
        "rospy.sleep(0.5)\n\n\ndef turn():\n    goal = JointPosition()\n"
        "    goal.position.a1 = 0.2\n    command.publish(goal)\n    rospy.sleep(2.0)\n\n\nturn()\n",
    )
    found = example.run("trace", "cell.py", "--json").json
    assert found["trace"]["robot"] == "iiwa7_stack"
    assert [each["ref"]["name"] for each in found["trace"]["functions"]] == ["turn"]
    (reason,) = found["verdict"]["reasons"]
    assert (reason["code"], reason["object"]) == ("robot-assumed", "iiwa7_stack")


@pytest.mark.parametrize(
    ("topic", "package", "kind"),
    [
        ("/iiwa/command/CartesianPose", "iiwa_msgs", "CartesianPose"),
        ("/iiwa/command/CartesianPoseLin", "iiwa_msgs", "CartesianPose"),
        ("/iiwa/command/JointPosition", "sensor_msgs", "JointState"),
    ],
)
def test_a_command_of_another_type_moves_nothing_and_both_types_are_named(
    run_on, topic, package, kind
):
    ran = run_on(
        "iiwa7_stack",
        f"""
import rospy
import iiwa_msgs.msg
from {package}.msg import {kind}
rospy.init_node('wrong')
iiwa_msgs.msg.JointPosition()
command = rospy.Publisher('{topic}', {kind}, queue_size=1)
rospy.sleep(0.5)
command.publish({kind}())
rospy.sleep(1.0)
""",
    )
    (words,) = [each for each in ran.findings if "no message arrives" in each]
    assert topic in words
    assert f"published as {package}/{kind}, and iiwa_stack takes " in words
    assert ran.recording.commands == ()
