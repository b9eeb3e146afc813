#!/usr/bin/env python3
"""Turns the base of a UR10e a little and leaves the other joints as they are (ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = dict(zip(JOINTS, [0.0, -1.3, 1.5, -1.87, -1.57, 0.0]))


class TurnBase(Node):
    def __init__(self):
        super().__init__("ur10e_turn_base")
        self.positions = {}
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.client.wait_for_server()

    def on_state(self, message):
        self.positions.update(zip(message.name, message.position))

    def go(self, target, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = list(target)
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=list(target.values()), time_from_start=Duration(sec=seconds)))
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        code = done.result().result.error_code
        if code != FollowJointTrajectory.Result.SUCCESSFUL:
            raise RuntimeError(f"error code {code}")

    def settle(self, seconds=0.5):
        end = self.get_clock().now().nanoseconds + int(seconds * 1e9)
        while self.get_clock().now().nanoseconds < end:
            rclpy.spin_once(self, timeout_sec=0.05)


def main():
    rclpy.init()
    node = TurnBase()
    node.go(HOME, 5)
    node.settle()
    target = {name: node.positions[name] for name in JOINTS}
    target["shoulder_pan_joint"] += 0.3
    node.go(target, 4)
    node.get_logger().info("turned")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
