#!/usr/bin/env python3
"""A UR5e with parameters that have a type and no default: they may be given, or not."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.exceptions import ParameterUninitializedException
from rclpy.node import Node
from rclpy.parameter import Parameter
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]


class Optional(Node):
    def __init__(self):
        super().__init__("optional_speed")
        self.declare_parameter("seconds", Parameter.Type.DOUBLE)
        self.declare_parameter("turn", Parameter.Type.DOUBLE)
        self.seconds = self.value_or("seconds", 2.5)
        self.turn = self.value_or("turn", 0.6)
        self.client = ActionClient(
            self, FollowJointTrajectory, "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.client.wait_for_server()

    def value_or(self, name, default):
        given = Parameter(name, Parameter.Type.DOUBLE, default)
        return self.get_parameter_or(name, given).value

    def given(self, name):
        try:
            return self.get_parameter(name).value
        except ParameterUninitializedException:
            return None

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


def main():
    rclpy.init()
    node = Optional()
    node.get_logger().info(f"seconds {node.seconds}, turn {node.turn}, given {node.given('turn')}")
    for sign in (1.0, -1.0, 0.0):
        status = node.move([sign * node.turn] + HOME[1:])
        node.get_logger().info(f"turned to {sign * node.turn}: status {status}")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
