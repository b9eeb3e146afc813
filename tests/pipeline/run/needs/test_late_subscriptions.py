"""Subscriptions that come after the only message, as a run reports them."""

import pytest

PROGRAM = """
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from MODULE import TYPE
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from builtin_interfaces.msg import Duration

rclpy.init()
node = rclpy.create_node("bend")
came = []
node.create_subscription(TYPE, "TOPIC", came.append, PROFILE)
command = node.create_publisher(
    JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)


def bend():
    rclpy.spin_once(node, timeout_sec=1.0)
    names = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
             "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
    point = JointTrajectoryPoint(
        positions=[0.0, -1.57, 0.5, -1.57, 0.0, 0.0], time_from_start=Duration(sec=3))
    command.publish(JointTrajectory(joint_names=names, points=[point]))


bend()
end = node.get_clock().now().nanoseconds + 4_000_000_000
while node.get_clock().now().nanoseconds < end:
    rclpy.spin_once(node, timeout_sec=0.5)
"""
LATCHED = "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)"


def _reasons(example, topic, message, profile):
    module, name = message.split(".")
    words = {"MODULE": f"{module}.msg", "TYPE": name, "TOPIC": topic, "PROFILE": profile}
    text = PROGRAM
    for word, value in words.items():
        text = text.replace(word, value)
    example.write("bend.py", text)
    trace = example.run("trace", "bend.py", "--robot", "ur5e", "--json").json["trace"]
    return [
        (reason["code"], reason["object"], reason["location"]["line"])
        for reason in trace["verdict"]["reasons"]
        if "volatile" in reason["words"]
    ]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("topic", "message"),
    [("/robot_description", "std_msgs.String"), ("/tf_static", "tf2_msgs.TFMessage")],
)
def test_a_volatile_subscription_of_what_was_published_once_is_a_reason(example, topic, message):
    assert _reasons(example, topic, message, "1") == [("unmet-need", topic, 12)]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("topic", "message", "profile"),
    [
        ("/robot_description", "std_msgs.String", LATCHED),
        ("/joint_states", "sensor_msgs.JointState", "1"),
    ],
)
def test_no_reason_is_what_comes_again_or_was_asked_for(example, topic, message, profile):
    assert _reasons(example, topic, message, profile) == []
