"""`/joint_states` of the twin, end to end, as a program reads it."""

from __future__ import annotations

PROGRAM = """\
import rospy
import moveit_commander
from sensor_msgs.msg import JointState

seen = []
rospy.init_node("listener")
first = rospy.wait_for_message("/joint_states", JointState)
arm = moveit_commander.MoveGroupCommander("panda_arm")
rospy.Subscriber("joint_states", JointState, seen.append)
arm.set_max_velocity_scaling_factor(0.5)
arm.set_named_target("ready")
began = rospy.get_time()
arm.go(wait=True)
lasted = rospy.get_time() - began
rate = len(seen) / lasted
elbow = seen[-1].name.index("panda_joint4")
assert 49 < rate < 51, rate
assert first.name == seen[-1].name and len(first.name) == 9
assert abs(seen[-1].position[elbow] - arm.get_current_joint_values()[3]) < 0.01
assert abs(first.position[elbow] - seen[-1].position[elbow]) > 0.1
assert any(abs(message.velocity[elbow]) > 0.1 for message in seen)
assert seen[0].header.stamp < seen[-1].header.stamp
rospy.spin()
"""


def test_joint_states_are_published_while_somebody_listens(example):
    example.write("listener.py", PROGRAM)
    outcome = example.run("trace", "listener.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "quiescent"


def test_a_message_that_nobody_publishes_is_named_with_the_line_that_waits(example):
    example.write("waiter.py", PROGRAM.replace("/joint_states", "/joint_stats"))
    outcome = example.run("trace", "waiter.py")
    assert outcome.code == 4
    assert "waiter.py:7" in outcome.err
    assert "a message on /joint_stats (sensor_msgs/JointState)" in outcome.err
