"""A controller that sends one trajectory, and the findings of its run."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces

PROGRAM = """\
import actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rospy.init_node("cell")
trajectory = JointTrajectory(joint_names=[f"panda_joint{n}" for n in range(1, 8)])
for seconds, pan in POINTS:
    trajectory.points.append(JointTrajectoryPoint(
        positions=[pan, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
        time_from_start=rospy.Duration(seconds)))
"""
BY_ACTION = """\
client = actionlib.SimpleActionClient(
    "/panda_arm_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
client.wait_for_server()
client.send_goal(FollowJointTrajectoryGoal(trajectory=trajectory))
client.wait_for_result()
"""
BY_TOPIC = """\
out = rospy.Publisher("/panda_arm_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(1.0)
out.publish(trajectory)
rospy.sleep(3.0)
"""
SENDS = {"action": BY_ACTION, "topic": BY_TOPIC}


@pytest.fixture
def reported(tmp_path: Path):
    """Runs it with the points (time [s], angle of the first joint [rad]), sent by an action or a
    topic; returns the findings of a kind."""

    def reported(kind, points, send):
        script = tmp_path / "cell.py"
        text = PROGRAM.replace("POINTS", repr(points)) + SENDS[send]
        script.write_text(text, encoding="utf-8")
        ran = quiet_end(*run_traced(script, Interfaces(), scene="empty", duration_s=30.0))
        return [finding for finding in ran.recording.findings if finding.kind == kind]

    return reported
