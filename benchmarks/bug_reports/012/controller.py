#!/usr/bin/env python3
"""Turns the base of a UR5e slowly by a row of set-points (ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Turn(Node):
    def __init__(self):
        super().__init__("ur5e_turn")
        self.positions = None
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.command = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)

    def on_state(self, message):
        self.positions = dict(zip(message.name, message.position))


def main():
    rclpy.init()
    node = Turn()
    while node.positions is None or node.command.get_subscription_count() == 0:
        rclpy.spin_once(node, timeout_sec=0.1)
    target = [node.positions[name] for name in JOINTS]

    rate = node.create_rate(10)
    for number in range(60):
        node.get_logger().info(f"set-point {number}")
        target[0] += 0.01
        message = JointTrajectory(joint_names=JOINTS)
        message.points.append(JointTrajectoryPoint(
            positions=list(target), time_from_start=Duration(nanosec=200_000_000)))
        node.command.publish(message)
        rate.sleep()
    node.get_logger().info("turned")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
