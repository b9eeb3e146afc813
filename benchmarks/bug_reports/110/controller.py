#!/usr/bin/env python3
"""Lift the forearm of a Panda by 20 degrees from wherever it is, and lower it again."""
import math

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
LIFT = math.radians(20.0)


class Lifter(Node):
    def __init__(self):
        super().__init__("wait_for_joints")
        self.joint_state = None
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")

    def on_state(self, msg):
        self.joint_state = msg

    def current(self):
        """Where the joints are, as soon as that is known."""
        rate = self.create_rate(10)
        while self.joint_state is None:
            self.get_logger().warn("joint states are not available yet")
            rate.sleep()
        where = dict(zip(self.joint_state.name, self.joint_state.position))
        return [where[name] for name in JOINTS]

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=2))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, result)
        self.get_logger().info(f"status {result.result().status}")


def main():
    rclpy.init()
    node = Lifter()
    node.client.wait_for_server()
    begin = node.current()
    lifted = list(begin)
    lifted[3] += LIFT
    node.move(lifted)
    node.move(begin)
    node.get_logger().info("done")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
