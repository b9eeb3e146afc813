#!/usr/bin/env python3
"""An action server in front of an FR3's controller; its goals are awaited, not spun for."""
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node


class Gate(Node):
    def __init__(self):
        super().__init__("fr3_gate")
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/fr3_arm_controller/follow_joint_trajectory")
        self.arm.wait_for_server()
        self.goals = 0
        self.server = ActionServer(self, FollowJointTrajectory, "/cell/move", self.execute)
        self.get_logger().info("gate is open")

    async def execute(self, goal_handle):
        self.goals += 1
        number = self.goals
        self.get_logger().info(f"goal {number}")
        forward = FollowJointTrajectory.Goal()
        forward.trajectory = goal_handle.request.trajectory

        handle = await self.arm.send_goal_async(forward)
        if not handle.accepted:
            goal_handle.abort()
            return FollowJointTrajectory.Result()
        response = await handle.get_result_async()

        if response.result.error_code == FollowJointTrajectory.Result.SUCCESSFUL:
            goal_handle.succeed()
        else:
            goal_handle.abort()
        self.get_logger().info(f"goal {number} done")
        return response.result


def main():
    rclpy.init()
    rclpy.spin(Gate())


if __name__ == "__main__":
    main()
