#!/usr/bin/env python3
"""Brings an FR3 to its rest pose (ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint


class Rest(Node):
    def __init__(self):
        super().__init__("fr3_rest")
        self.client = ActionClient(
            self, FollowJointTrajectory, "/fr3_arm_controller/follow_joint_trajectory")

    def run(self):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = [f"fr3_joint{i}" for i in range(1, 8)]
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=[0.3, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
            time_from_start=Duration(sec=4)))
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, result)
        self.get_logger().info("at rest")


NODE = Rest()


def main():
    rclpy.init()
    NODE.run()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
