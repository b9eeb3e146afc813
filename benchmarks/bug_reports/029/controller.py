#!/usr/bin/env python3
"""Sends a UR5e to its parking pose and waits until it should be there."""
import time

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
PARKED = [1.0, -1.8, 1.9, -1.67, -1.57, 0.0]


def main():
    rclpy.init()
    node = Node("ur5e_park")
    publisher = node.create_publisher(
        JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 1)
    message = JointTrajectory()
    message.joint_names = JOINTS
    message.points.append(
        JointTrajectoryPoint(positions=PARKED, time_from_start=Duration(sec=5)))
    publisher.publish(message)
    node.get_logger().info("parking")
    time.sleep(8.0)
    node.get_logger().info("parked")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
