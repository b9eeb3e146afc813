#!/usr/bin/env python3
"""Switches a UR10e to its position controller and streams a slow turn of the base (ROS 2)."""
import rclpy
from controller_manager_msgs.srv import SwitchController
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
        self.positions = {}
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.publisher = self.create_publisher(
            Float64MultiArray, "/forward_position_controller/commands", 10)
        self.switch = self.create_client(
            SwitchController, "/controller_manager/switch_controller")

    def on_state(self, message):
        self.positions.update(zip(message.name, message.position))

    def activate(self):
        self.switch.wait_for_service()
        request = SwitchController.Request()
        request.activate_controllers = ["forward_position_controller"]
        request.deactivate_controllers = ["scaled_joint_trajectory_controller"]
        request.strictness = SwitchController.Request.STRICT
        future = self.switch.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        if not future.result().ok:
            raise RuntimeError("the controllers were not switched")

    def turn(self):
        while len(self.positions) < len(JOINTS) or self.publisher.get_subscription_count() == 0:
            rclpy.spin_once(self, timeout_sec=0.1)
        start = [self.positions[name] for name in JOINTS]
        rate = 0.02
        for step in range(1, STEPS + 51):
            command = Float64MultiArray()
            command.data = list(start)
            command.data[0] += ANGLE * min(step, STEPS) / STEPS
            self.publisher.publish(command)
            end = self.get_clock().now().nanoseconds + int(rate * 1e9)
            while self.get_clock().now().nanoseconds < end:
                rclpy.spin_once(self, timeout_sec=rate)


def main():
    rclpy.init()
    node = Stream()
    node.activate()
    node.turn()
    node.get_logger().info("done")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
