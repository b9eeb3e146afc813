#!/usr/bin/env python3
"""Make a round with a Panda, step by step in a timer, and end the node when it is done."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
ROUND = [
    [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
    [0.5, -0.5, 0.0, -2.1, 0.0, 1.7, 0.785],
    [-0.5, -0.5, 0.0, -2.1, 0.0, 1.7, 0.785],
    [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
]


class Rounds(Node):
    def __init__(self):
        super().__init__("timed_rounds")
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
        self.todo = list(ROUND)
        self.accepted = None
        self.result = None
        self.timer = self.create_timer(0.1, self.step)

    def send(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=2))]
        self.accepted = self.client.send_goal_async(goal)
        self.result = None

    def step(self):
        if self.accepted is None:
            if self.client.server_is_ready():
                self.send(self.todo.pop(0))
            return
        if self.result is None:
            if self.accepted.done():
                self.result = self.accepted.result().get_result_async()
            return
        if not self.result.done():
            return
        self.get_logger().info(f"{len(self.todo)} stops to go")
        if self.todo:
            self.send(self.todo.pop(0))
        else:
            self.get_logger().info("round finished")
            rclpy.shutdown()


def main():
    rclpy.init()
    node = Rounds()
    rclpy.spin(node)
    print("node ended, the cell may be opened")


if __name__ == "__main__":
    main()
