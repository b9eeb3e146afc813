#!/usr/bin/env python3
"""Lowers the arm of a UR5e in steps whose size is a parameter."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Lower(Node):
    def __init__(self):
        super().__init__("ur5e_lower")
        self.declare_parameter("steps", 3)
        self.steps = self.get_parameter("steps").value
        self.height = self.get_parameter("approach_height").value or 0.1
        self.arm = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")

    def run(self):
        self.arm.wait_for_server()
        for step in range(self.steps):
            lift = -1.5 + self.height * step
            goal = FollowJointTrajectory.Goal()
            goal.trajectory.joint_names = JOINTS
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=[0.0, lift, 1.6, -1.67, -1.57, 0.0],
                time_from_start=Duration(sec=3)))
            sent = self.arm.send_goal_async(goal)
            rclpy.spin_until_future_complete(self, sent)
            result = sent.result().get_result_async()
            rclpy.spin_until_future_complete(self, result)
            self.get_logger().info(f"step {step} done")


def main():
    rclpy.init()
    Lower().run()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
