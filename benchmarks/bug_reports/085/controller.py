#!/usr/bin/env python3
"""Logs where the tool of a UR5e is, then turns the wrist (ROS 2)."""
import time

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import Buffer, TransformException, TransformListener
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Tool(Node):
    def __init__(self):
        super().__init__("ur5e_tool")
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.command = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)

    def where(self):
        for _ in range(10):
            try:
                return self.buffer.lookup_transform("base_link", "tool0", Time())
            except TransformException as error:
                self.get_logger().warning(str(error))
                time.sleep(0.5)
        raise RuntimeError("no transform")

    def turn(self):
        message = JointTrajectory(joint_names=JOINTS)
        message.points.append(JointTrajectoryPoint(
            positions=[0.0, -1.57, 1.57, -1.57, -1.57, 0.8], time_from_start=Duration(sec=5)))
        self.command.publish(message)


def main():
    rclpy.init()
    node = Tool()
    place = node.where().transform.translation
    node.get_logger().info(f"tool at {place.x:.2f} {place.y:.2f} {place.z:.2f}")
    node.turn()
    time.sleep(6.0)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
