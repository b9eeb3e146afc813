#!/usr/bin/env python3
"""An action server in front of an FR3's controller that counts the goals and logs them."""
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Gate(Node):
    def __init__(self):
        super().__init__("fr3_gate")
        group = ReentrantCallbackGroup()
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/fr3_arm_controller/follow_joint_trajectory",
            callback_group=group)
        self.arm.wait_for_server()
        self.goals = 0
        self.server = ActionServer(
            self, FollowJointTrajectory, "/cell/move", self.execute, callback_group=group)
        self.get_logger().info("gate is open")

    def execute(self, goal_handle):
        self.goals += 1
        self.get_logger().info(f"goal {self.goals}")
        forward = FollowJointTrajectory.Goal()
        forward.trajectory = goal_handle.request.trajectory

        sent = self.arm.send_goal_async(forward)
        rclpy.spin_until_future_complete(self, sent)
        handle = sent.result()
        if not handle.accepted:
            goal_handle.abort()
            return FollowJointTrajectory.Result()
        finished = handle.get_result_async()
        rclpy.spin_until_future_complete(self, finished)

        goal_handle.succeed()
        self.get_logger().info(f"goal {self.goals} done")
        return finished.result().result


def main():
    rclpy.init()
    gate = Gate()
    executor = MultiThreadedExecutor()
    executor.add_node(gate)
    executor.spin()


if __name__ == "__main__":
    main()
