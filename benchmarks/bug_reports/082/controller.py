#!/usr/bin/env python3
"""Sweeps the base of a Panda through three points at a constant speed (ROS 2 Jazzy)."""
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
REST = [-0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
SPEED = 0.15


class Sweep(Node):
    def __init__(self):
        super().__init__("panda_sweep")
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")

    def run(self):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        for number, angle in enumerate((0.0, 0.3, 0.6)):
            point = JointTrajectoryPoint()
            point.positions = [angle] + REST
            point.velocities = [SPEED] + [0.0] * 6
            point.time_from_start = Duration(seconds=4.0 + 2.0 * number).to_msg()
            goal.trajectory.points.append(point)
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        if not sent.result().accepted:
            self.get_logger().error("rejected")
            return
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, result)
        self.get_logger().info("swept")


def main():
    rclpy.init()
    Sweep().run()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
