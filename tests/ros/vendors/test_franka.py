"""What franka_ros serves: settings, recovery, and the pose of its impedance controller."""

import pytest


@pytest.mark.parametrize("package", ["franka_msgs", "franka_control"])
def test_settings_are_taken_and_reported_of_and_errors_recovered(run_on, package):
    ran = run_on(
        "panda",
        f"""
import actionlib
import rospy
from {package}.msg import ErrorRecoveryAction, ErrorRecoveryActionGoal, ErrorRecoveryGoal
from {package}.srv import SetKFrame, SetKFrameRequest
rospy.init_node('settings')
rospy.wait_for_service('/franka_control/set_K_frame')
stiff = rospy.ServiceProxy('/franka_control/set_K_frame', SetKFrame)
answer = stiff(SetKFrameRequest())
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
        "set_K_frame: taken, and changes nothing: the twin's joints keep their own servos"
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


SET_EE = """
import rospy
from franka_msgs.msg import FrankaState
from franka_msgs.srv import SetEEFrame
rospy.init_node('tool')
def tip():
    return rospy.wait_for_message('/franka_state_controller/franka_states', FrankaState).O_T_EE
before = tip()
set_frame = rospy.ServiceProxy('/franka_control/set_EE_frame', SetEEFrame)
answer = set_frame(MATRIX)
after = tip()
"""
ALONG_Z = "[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, {}, 1]"


@pytest.mark.parametrize("length", [0.1, -0.05])
def test_the_pose_of_the_arm_is_that_of_the_frame_that_is_set(run_on, length):
    ran = run_on("panda", SET_EE.replace("MATRIX", ALONG_Z.format(length)))
    assert ran["answer"].success
    assert ran.findings == []
    # The hand of a Panda at rest looks down.
    assert ran["after"][14] - ran["before"][14] == pytest.approx(-length, abs=0.01)
    assert ran["after"][:11] == pytest.approx(ran["before"][:11], abs=1e-3)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "matrix", ["[0] * 16", "[2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]", "[1, 0] * 8"]
)
def test_a_frame_that_is_no_transformation_is_refused(run_on, matrix):
    ran = run_on("panda", SET_EE.replace("MATRIX", matrix))
    assert not ran["answer"].success
    assert "is no transformation of a rigid body" in ran.findings[0]
    assert ran["after"] == pytest.approx(ran["before"], abs=1e-3)


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
