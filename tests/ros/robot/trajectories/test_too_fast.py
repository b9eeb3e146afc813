"""Trajectories that a joint cannot follow in their time, and the finding that says so."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.common.traced.findings import NOTES
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


@pytest.fixture
def told(tmp_path: Path):
    def told(points, send):
        script = tmp_path / "cell.py"
        script.write_text(PROGRAM.replace("POINTS", repr(points)) + send, encoding="utf-8")
        ran = quiet_end(*run_traced(script, Interfaces(), scene="empty", duration_s=30.0))
        return [each for each in ran.recording.findings if each.kind == "too_fast"]

    return told


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("send", [BY_ACTION, BY_TOPIC])
@pytest.mark.parametrize(
    "points", [[(0.2, 1.5)], [(2.0, 0.3), (2.15, 1.2)], [(1.0, 0.5), (1.1, 0.0), (3.0, 0.0)]]
)
def test_a_way_that_a_joint_cannot_follow_is_told_of(told, points, send):
    (finding,) = told(points, send)
    assert finding.object == "panda_joint1"
    assert "and its limit 2.17 rad/s" in finding.message
    assert finding.location.line > 9
    assert finding.kind in NOTES


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("send", [BY_ACTION, BY_TOPIC])
@pytest.mark.parametrize("points", [[(2.0, 1.5)], [(0.5, 0.9)], [(0.04, 0.3)]])
def test_one_that_it_can_or_that_a_stream_may_have_is_not(told, points, send):
    assert not told(points, send)
