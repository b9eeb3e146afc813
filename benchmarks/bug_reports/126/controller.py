#!/usr/bin/env python3
"""A UR5e goes to the goals of its parameter file one after the other, as often as asked."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Goals(Node):
    def __init__(self):
        super().__init__("move_between")
        self.declare_parameter("goal_names", ["pos1", "pos2"])
        self.declare_parameter("seconds", 3)
        self.declare_parameter("rounds", 2)
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.client.wait_for_server()
        self.goals = []

    def read(self):
        """Each goal is a list of joint positions of its own name."""
        for name in self.get_parameter("goal_names").value:
            self.declare_parameter(name, Parameter.Type.DOUBLE_ARRAY)
            positions = list(self.get_parameter(name).value)
            if len(positions) != len(JOINTS):
                raise RuntimeError(f"{name} has {len(positions)} positions")
            self.goals.append((name, positions))
            self.get_logger().info(f"{name}: {positions}")

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions,
            time_from_start=Duration(sec=self.get_parameter("seconds").value))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        if not sent.result().accepted:
            raise RuntimeError("the goal was rejected")
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().result.error_code


def main():
    rclpy.init()
    node = Goals()
    node.read()
    for turn in range(node.get_parameter("rounds").value):
        for name, positions in node.goals:
            code = node.move(positions)
            node.get_logger().info(f"round {turn + 1}, {name}: error code {code}")
    node.get_logger().info("all rounds done")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
