"""What franka_ros serves: settings, recovery, and the pose of its impedance controller."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize("package", ["franka_msgs", "franka_control"])
def test_settings_are_taken_and_reported_of_and_errors_recovered(run_on, package):
    ran = run_on(
        "panda",
        f"""
import actionlib
import rospy
from {package}.msg import ErrorRecoveryAction, ErrorRecoveryActionGoal, ErrorRecoveryGoal
from {package}.srv import SetEEFrame, SetEEFrameRequest
rospy.init_node('settings')
rospy.wait_for_service('/franka_control/set_EE_frame')
answer = rospy.ServiceProxy('/franka_control/set_EE_frame', SetEEFrame)(SetEEFrameRequest())
client = actionlib.SimpleActionClient('/franka_control/error_recovery', ErrorRecoveryAction)
client.wait_for_server()
state = client.send_goal_and_wait(ErrorRecoveryGoal())
publisher = rospy.Publisher(
    '/franka_control/error_recovery/goal', ErrorRecoveryActionGoal, queue_size=1)
publisher.publish(ErrorRecoveryActionGoal())
""",
    )
    assert ran["answer"].success
    assert ran["state"] == 3
    assert ran.findings == [
        "set_EE_frame: taken, and changes nothing: the twin's joints keep their own servos"
    ]


def test_the_arm_follows_the_pose_of_the_impedance_controller(run_on):
    ran = run_on(
        "panda",
        """
import rospy
from geometry_msgs.msg import PoseStamped
rospy.init_node('stream')
publisher = rospy.Publisher(
    '/cartesian_impedance_example_controller/equilibrium_pose', PoseStamped, queue_size=1)
pose = PoseStamped()
pose.header.frame_id = 'panda_link0'
pose.pose.position.x, pose.pose.position.z = 0.4, 0.5
pose.pose.orientation.x = 1.0
for step in range(100):
    pose.pose.position.y = 0.001 * step
    publisher.publish(pose)
    rospy.sleep(0.02)
rospy.sleep(1.0)
""",
    )
    # The end effector of a Panda with its hand lies between the fingers.
    tool = ran.twin.link_pose("panda_hand_tcp").position
    assert tool == pytest.approx((0.4, 0.099, 0.5), abs=0.003)


def test_the_state_of_the_arm_is_published_with_its_pose_as_a_matrix(run_on):
    ran = run_on(
        "panda",
        """
import rospy
from franka_msgs.msg import FrankaState
rospy.init_node('state')
state = rospy.wait_for_message('/franka_state_controller/franka_states', FrankaState, timeout=5.0)
""",
    )
    state = ran["state"]
    tool = ran.twin.link_pose("panda_hand_tcp")
    assert state.O_T_EE[12:15] == pytest.approx(tool.position, abs=1e-4)
    assert (state.O_T_EE[3], state.O_T_EE[15]) == (0.0, 1.0)
    # The tool of a Panda that is ready points down: the third column is its axis.
    assert state.O_T_EE[8:11] == pytest.approx((0.0, 0.0, -1.0), abs=0.05)
    assert state.q[3] == pytest.approx(ran.position("panda_joint4"), abs=1e-3)
    assert state.robot_mode == state.ROBOT_MODE_MOVE
