#!/usr/bin/env python3
"""Tend a machine with a UR5e; speed and rounds are parameters of the launch file."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
TABLE = [0.0, -1.3, 1.5, -1.77, -1.57, 0.0]
MACHINE = [1.0, -1.3, 1.5, -1.77, -1.57, 0.0]


class Tend(Node):
    def __init__(self):
        super().__init__("tend", automatically_declare_parameters_from_overrides=True)
        self.declare_parameters("", [
            ("seconds_per_move", 3.0),
            ("rounds", 1),
            ("controller", "scaled_joint_trajectory_controller"),
        ])
        self.seconds = self.get_parameter("seconds_per_move").value
        self.rounds = self.get_parameter("rounds").value
        name = self.get_parameter("controller").value
        self.client = ActionClient(self, FollowJointTrajectory, f"/{name}/follow_joint_trajectory")
        self.client.wait_for_server()

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        whole = int(self.seconds)
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions,
            time_from_start=Duration(sec=whole, nanosec=int((self.seconds - whole) * 1e9)))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().status

    def run(self):
        for number in range(self.rounds):
            self.move(TABLE)
            self.move(MACHINE)
            self.get_logger().info(f"round {number + 1} of {self.rounds}")


def main():
    rclpy.init()
    Tend().run()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
