#!/usr/bin/env python3
"""Ask the door before each motion, in a timer callback that waits for both (UR5e, ROS 2)."""
import threading

import rclpy
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
STOPS = [
    [0.0, -1.57, 1.57, -1.57, -1.57, 0.0],
    [0.7, -1.3, 1.4, -1.67, -1.57, 0.0],
    [0.0, -1.57, 1.57, -1.57, -1.57, 0.0],
]


class Cell(Node):
    def __init__(self):
        super().__init__("door_and_arm")
        # Three groups: the timer waits while the answers of the other two come in.
        self.door = self.create_client(Trigger, "/door/close",
                                       callback_group=MutuallyExclusiveCallbackGroup())
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/scaled_joint_trajectory_controller/follow_joint_trajectory",
            callback_group=MutuallyExclusiveCallbackGroup())
        self.finished = threading.Event()
        self.stops = list(STOPS)
        self.timer = self.create_timer(0.5, self.work,
                                       callback_group=MutuallyExclusiveCallbackGroup())

    def wait(self, future):
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        done.wait()
        return future.result()

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=3))]
        handle = self.wait(self.arm.send_goal_async(goal))
        if not handle.accepted:
            return False
        return self.wait(handle.get_result_async()).status == GoalStatus.STATUS_SUCCEEDED

    def work(self):
        if not self.stops:
            self.timer.cancel()
            self.finished.set()
            return
        answer = self.door.call(Trigger.Request())
        self.get_logger().info(f"door closed: {answer.success}")
        moved = self.move(self.stops.pop(0))
        self.get_logger().info(f"moved: {moved}, {len(self.stops)} to go")


def main():
    rclpy.init()
    cell = Cell()
    cell.door.wait_for_service()
    cell.arm.wait_for_server()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(cell)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    cell.finished.wait()
    cell.get_logger().info("all stops served")
    rclpy.shutdown()
    thread.join()


if __name__ == "__main__":
    main()
