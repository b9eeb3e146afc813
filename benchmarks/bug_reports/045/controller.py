#!/usr/bin/env python3
"""Streams a slow turn of the base to the position controller of a UR10e (ROS 2 driver)."""
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
ANGLE = 0.4
STEPS = 200


class Stream(Node):
    def __init__(self):
        super().__init__("ur10e_stream")
        self.start = None
        self.step = 0
        self.publisher = self.create_publisher(
            Float64MultiArray, "/forward_position_controller/commands", 10)
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.timer = self.create_timer(0.02, self.on_timer)

    def on_state(self, message):
        if self.start is None:
            positions = dict(zip(message.name, message.position))
            self.start = [positions[name] for name in JOINTS]

    def on_timer(self):
        if self.start is None or self.publisher.get_subscription_count() == 0:
            return
        self.step += 1
        command = Float64MultiArray()
        command.data = list(self.start)
        command.data[0] += ANGLE * min(self.step, STEPS) / STEPS
        self.publisher.publish(command)
        if self.step > STEPS + 50:
            self.get_logger().info("done")
            raise SystemExit


def main():
    rclpy.init()
    try:
        rclpy.spin(Stream())
    except SystemExit:
        rclpy.shutdown()


if __name__ == "__main__":
    main()
