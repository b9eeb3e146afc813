#!/usr/bin/env python3
"""Turns the base of a Panda for two seconds at a constant speed (ROS 2 Humble)."""
import sys

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]


def at(speed, seconds):
    point = JointTrajectoryPoint()
    point.velocities = [speed] + [0.0] * 6
    point.time_from_start = Duration(
        sec=int(seconds), nanosec=int((seconds % 1.0) * 1e9))
    return point


def main():
    rclpy.init()
    node = Node("panda_constant_speed")
    client = ActionClient(
        node, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
    client.wait_for_server()
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [at(0.2, 0.5), at(0.2, 2.0), at(0.0, 2.5)]

    sent = client.send_goal_async(goal)
    rclpy.spin_until_future_complete(node, sent)
    handle = sent.result()
    if not handle.accepted:
        node.get_logger().error("rejected")
        rclpy.shutdown()
        sys.exit(1)
    done = handle.get_result_async()
    rclpy.spin_until_future_complete(node, done)
    node.get_logger().info("turned")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
