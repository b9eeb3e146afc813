#!/usr/bin/env python3
"""A UR5e serves an action that turns its wrist in small moves; a guard in the same program calls it off."""
import threading

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
ARM = "/scaled_joint_trajectory_controller/follow_joint_trajectory"
TURN = "/cell/turn_wrist"


def goal_of(positions, seconds):
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [
        JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=seconds))]
    return goal


class Turner(Node):
    def __init__(self):
        super().__init__("wrist_turner")
        group = ReentrantCallbackGroup()
        self.arm = ActionClient(self, FollowJointTrajectory, ARM, callback_group=group)
        self.moves = 0
        self.started = threading.Event()
        self.server = ActionServer(
            self, FollowJointTrajectory, TURN, self.execute,
            cancel_callback=self.on_cancel, callback_group=group)

    def on_cancel(self, handle):
        self.get_logger().info("cancel received")
        return CancelResponse.ACCEPT

    async def move(self, positions, seconds):
        handle = await self.arm.send_goal_async(goal_of(positions, seconds))
        answer = await handle.get_result_async()
        return answer.result.error_code

    async def execute(self, handle):
        result = FollowJointTrajectory.Result()
        for number in range(1, 9):
            if handle.is_cancel_requested:
                handle.canceled()
                self.get_logger().info(f"called off after {self.moves} moves")
                return result
            result.error_code = await self.move(HOME[:5] + [0.2 * number], 1)
            self.moves = number
            self.started.set()
        handle.succeed()
        return result


class Guard(Node):
    def __init__(self):
        super().__init__("wrist_guard")
        self.client = ActionClient(self, FollowJointTrajectory, TURN)

    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()


def main():
    rclpy.init()
    turner = Turner()
    turner.arm.wait_for_server()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(turner)
    threading.Thread(target=executor.spin, daemon=True).start()
    guard = Guard()
    guard.client.wait_for_server()
    handle = guard.wait(guard.client.send_goal_async(goal_of(HOME, 1)))
    turner.started.wait()
    answer = guard.wait(handle.cancel_goal_async())
    guard.get_logger().info(f"cancelling {len(answer.goals_canceling)} goals")
    status = guard.wait(handle.get_result_async()).status
    guard.get_logger().info(f"status {status}, {turner.moves} of 8 moves")
    executor.shutdown()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
