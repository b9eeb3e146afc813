#!/usr/bin/env python3
"""Lifts a UR5e's arm a little from wherever it is (ROS 2, ported from rospy)."""
import time

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Lift(Node):
    def __init__(self):
        super().__init__("ur5e_lift")
        self.positions = None
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.command = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)

    def on_state(self, message):
        self.positions = dict(zip(message.name, message.position))

    def run(self):
        while self.positions is None:
            self.get_logger().info("waiting for joint states")
            time.sleep(1.0)
        self.get_logger().info("moving")
        target = [self.positions[name] for name in JOINTS]
        target[1] -= 0.2
        message = JointTrajectory(joint_names=JOINTS)
        message.points.append(JointTrajectoryPoint(
            positions=target, time_from_start=Duration(sec=3)))
        self.command.publish(message)
        time.sleep(4.0)


def main():
    rclpy.init()
    node = Lift()
    node.run()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
