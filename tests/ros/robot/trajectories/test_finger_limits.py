"""Fingers that a trajectory sends past their limits stop there, and the verdict says so."""

import pytest

PROGRAM = """\
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("hand")
hand = JointTrajectory(joint_names=["panda_finger_joint1", "panda_finger_joint2"])
hand.points = [JointTrajectoryPoint(positions=GOAL, time_from_start=rospy.Duration(1))]
"""
BY_ACTION = """\
client = actionlib.SimpleActionClient(
    "/panda_hand_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
client.wait_for_server()
client.send_goal(FollowJointTrajectoryGoal(trajectory=hand))
client.wait_for_result()
"""
BY_TOPIC = """\
publisher = rospy.Publisher("/panda_hand_controller/command", JointTrajectory, queue_size=1)
while not publisher.get_num_connections():
    rospy.sleep(0.1)
publisher.publish(hand)
rospy.sleep(2)
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("sent", [BY_ACTION, BY_TOPIC], ids=["by action", "by topic"])
@pytest.mark.parametrize(
    ("goal", "told"),
    [
        ([0.02, 0.02], []),
        ([0.041, 0.041], []),  # pressed open
        ([0.02, 0.09], [("panda_finger_joint2", "to 0.09, past its limits [0, 0.04]")]),
        ([-0.03, 0.0], [("panda_finger_joint1", "to -0.03, past its limits [0, 0.04]")]),
    ],
    ids=["within", "hardly past", "too wide", "below closed"],
)
def test_a_goal_past_the_limits_of_a_finger_is_told(example, sent, goal, told):
    example.write("hand.py", PROGRAM.replace("GOAL", str(goal)) + sent)
    outcome = example.run("trace", "hand.py", "--robot", "panda", "--json")
    reasons = [
        reason
        for reason in outcome.json["trace"]["verdict"]["reasons"]
        if reason["code"] == "stopped-at-limit"
    ]
    assert [reason["object"] for reason in reasons] == [joint for joint, _ in told], outcome.err
    for reason, (_, words) in zip(reasons, told, strict=True):
        assert f"{words}; it stops there" in reason["words"]
