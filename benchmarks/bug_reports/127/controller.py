#!/usr/bin/env python3
"""A UR5e takes a sample out of an oven: it waits before the door, reaches in, and retreats.

How long it waits in the heat and how far it retreats are in the cell's parameter file.
"""
import time

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
BEFORE_DOOR = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
IN_OVEN = [0.0, -1.2, 1.57, -1.94, -1.57, 0.0]


class Oven(Node):
    def __init__(self):
        super().__init__("oven_sampler")
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.client.wait_for_server()

    def move(self, name, positions, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions, time_from_start=Duration(sec=seconds))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        self.get_logger().info(f"{name}: error code {done.result().result.error_code}")

    def approach(self):
        self.move("before the door", BEFORE_DOOR, 3)

    def sample(self):
        self.move("in the oven", IN_OVEN, 3)
        time.sleep(self.get_parameter("soak_seconds").value)

    def retreat(self):
        turn = self.get_parameter("retreat_turn").value
        away = [turn] + BEFORE_DOOR[1:]
        self.move("before the door", BEFORE_DOOR, 2)
        self.move("at the bench", away, 3)


def main():
    rclpy.init()
    node = Oven()
    node.approach()
    node.sample()
    node.retreat()
    node.get_logger().info("the sample is on the bench")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
