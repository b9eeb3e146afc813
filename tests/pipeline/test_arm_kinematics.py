"""Controllers that read the robot's description and solve its kinematics themselves."""

from __future__ import annotations

READER = """\
from xml.etree import ElementTree
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

rclpy.init()
node = Node("reader")
texts = []
late = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "/robot_description", lambda each: texts.append(each.data), late)
rclpy.spin_once(node, timeout_sec=2.0)
top = ElementTree.fromstring(texts[0])
print("read", top.get("name"), round(sum(float(each.get("value")) for each in top.iter("mass"))))
"""


def test_the_robots_description_is_a_topic_of_ros_2(example):
    example.write("reader.py", READER)
    outcome = example.run("trace", "reader.py", "--robot", "panda")
    assert "read panda 17" in outcome.out + outcome.err
