#!/usr/bin/env python3
"""Jogs the hand of a Panda upwards by MoveIt Servo (ROS 2 Humble)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from geometry_msgs.msg import TwistStamped
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


class Jog(Node):
    def __init__(self):
        super().__init__("panda_jog")
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
        self.twist = self.create_publisher(TwistStamped, "/servo_node/delta_twist_cmds", 10)
        self.left = 150

    def ready(self):
        self.arm.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = [f"panda_joint{i}" for i in range(1, 8)]
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=READY, time_from_start=Duration(sec=4)))
        sent = self.arm.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        result = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, result)

    def jog(self):
        self.timer = self.create_timer(0.02, self.on_timer)
        while rclpy.ok() and self.left > 0:
            rclpy.spin_once(self)
        self.get_logger().info("jogged")

    def on_timer(self):
        self.left -= 1
        message = TwistStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "panda_link0"
        message.twist.linear.z = 0.1 if self.left > 0 else 0.0
        self.twist.publish(message)


def main():
    rclpy.init()
    node = Jog()
    node.ready()
    node.jog()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
