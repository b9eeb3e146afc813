#!/usr/bin/env python3
"""Turns only the last two joints of a UR3e's wrist (ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint


class Wrist(Node):
    def __init__(self):
        super().__init__("ur3e_wrist")
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")

    def turn(self, wrist_2, wrist_3):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = ["wrist_2_joint", "wrist_3_joint"]
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=[wrist_2, wrist_3], velocities=[0.0, 0.0],
            time_from_start=Duration(sec=3)))
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        handle = sent.result()
        if not handle.accepted:
            self.get_logger().error("the goal was rejected")
            return
        done = handle.get_result_async()
        rclpy.spin_until_future_complete(self, done)
        self.get_logger().info(f"turned, error code {done.result().result.error_code}")


def main():
    rclpy.init()
    Wrist().turn(-1.2, 0.5)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
