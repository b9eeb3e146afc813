#!/usr/bin/env python3
"""A hand wheel turns the wrist of a UR5e: one node reads the wheel, another follows it."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
CONTROLLER = "/scaled_joint_trajectory_controller"
WHEEL = "/cell/hand_wheel"
CLICKS = 20
CLICK = 0.05        # [rad]


class HandWheel(Node):
    """The wheel is a sensor: a lost click is no harm, the next one tells the whole angle."""

    def __init__(self):
        super().__init__("hand_wheel")
        self.angle = self.create_publisher(Float64, WHEEL, qos_profile_sensor_data)
        self.timer = self.create_timer(0.1, self.click)
        self.clicks = 0

    def click(self):
        if self.clicks < CLICKS:
            self.clicks += 1
            self.angle.publish(Float64(data=CLICK * self.clicks))


class Follower(Node):
    def __init__(self):
        super().__init__("wrist_follower")
        self.client = ActionClient(
            self, FollowJointTrajectory, CONTROLLER + "/follow_joint_trajectory")
        self.setpoint = self.create_publisher(
            JointTrajectory, CONTROLLER + "/joint_trajectory", 10)
        self.create_subscription(Float64, WHEEL, self.on_angle, 10)
        self.followed = 0

    def home(self):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=HOME, time_from_start=Duration(sec=3))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        self.get_logger().info(f"home: error code {done.result().result.error_code}")

    def on_angle(self, msg):
        self.followed += 1
        self.setpoint.publish(JointTrajectory(
            joint_names=JOINTS,
            points=[JointTrajectoryPoint(
                positions=HOME[:5] + [msg.data],
                time_from_start=Duration(nanosec=200_000_000))]))


def main():
    rclpy.init()
    follower = Follower()
    follower.home()
    wheel = HandWheel()
    executor = SingleThreadedExecutor()
    executor.add_node(wheel)
    executor.add_node(follower)
    while wheel.clicks < CLICKS:
        executor.spin_once(timeout_sec=0.1)
    for _ in range(10):
        executor.spin_once(timeout_sec=0.1)
    follower.get_logger().info(f"followed {follower.followed} of {wheel.clicks} clicks")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
