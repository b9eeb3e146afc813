#!/usr/bin/env python3
"""Follows the part of a list of waypoints in which the elbow is up (UR5e, ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
WAYPOINTS = [
    [0.0, -1.4, 1.6, -1.77, -1.57, 0.0],
    [0.3, -1.4, 1.6, -1.77, -1.57, 0.0],
    [0.3, -1.2, 1.4, -1.77, -1.57, 0.0],
]


def elbow_up(positions):
    return positions[2] < 0.0


class Follow(Node):
    def __init__(self):
        super().__init__("ur5e_follow")
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")

    def run(self):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        for number, positions in enumerate(filter(elbow_up, WAYPOINTS), 1):
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=positions, time_from_start=Duration(sec=4 * number)))
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        if not sent.result().accepted:
            raise RuntimeError("the goal was rejected")
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, result)
        self.get_logger().info("followed")


def main():
    rclpy.init()
    Follow().run()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
