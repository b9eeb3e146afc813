#!/usr/bin/env python3
"""Reads the limits of a UR5e's elbow from its description and bends it half way (ROS 2)."""
import xml.etree.ElementTree as ElementTree

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Bend(Node):
    def __init__(self):
        super().__init__("ur5e_bend")
        self.upper = None
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, "/robot_description", self.on_description, latched)
        self.command = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)

    def on_description(self, message):
        for joint in ElementTree.fromstring(message.data).iter("joint"):
            if joint.get("name") == "elbow_joint":
                self.upper = float(joint.find("limit").get("upper"))
                self.get_logger().info(f"upper limit {self.upper:.2f}")

    def bend(self):
        while self.upper is None or self.command.get_subscription_count() == 0:
            rclpy.spin_once(self, timeout_sec=0.5)
        message = JointTrajectory(joint_names=JOINTS)
        message.points.append(JointTrajectoryPoint(
            positions=[0.0, -1.57, 0.5 * self.upper, -1.57, -1.57, 0.0],
            time_from_start=Duration(sec=6)))
        self.command.publish(message)


def main():
    rclpy.init()
    node = Bend()
    node.bend()
    end = node.get_clock().now().nanoseconds + 7_000_000_000
    while node.get_clock().now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.5)
    node.get_logger().info("bent")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
