"""franka_control's settings and recovery, by the messages of its releases."""

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
