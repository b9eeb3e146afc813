#!/usr/bin/env python3
"""Wiggle the last wrist joint of a UR5e by the forward position controller (ROS 2)."""
import math

import rclpy
from controller_manager_msgs.srv import ListControllers, SwitchController
from rclpy.duration import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
AMPLITUDE = 0.3
PERIOD = 4.0


class Wiggle(Node):
    def __init__(self):
        super().__init__("forward_wiggle")
        self.where = {}
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.out = self.create_publisher(Float64MultiArray, "/forward_position_controller/commands", 10)
        self.switch = self.create_client(SwitchController, "/controller_manager/switch_controller")
        self.listing = self.create_client(ListControllers, "/controller_manager/list_controllers")
        self.switch.wait_for_service()
        self.listing.wait_for_service()

    def on_state(self, msg):
        self.where = dict(zip(msg.name, msg.position))

    def call(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def use_forward_controller(self):
        request = SwitchController.Request()
        request.activate_controllers = ["forward_position_controller"]
        self.call(self.switch, request)
        for controller in self.call(self.listing, ListControllers.Request()).controller:
            self.get_logger().info(f"{controller.name}: {controller.state}")

    def wiggle(self, seconds):
        while not self.where:
            rclpy.spin_once(self, timeout_sec=0.1)
        begin = [self.where[name] for name in JOINTS]
        low = high = begin[5]
        steps = int(seconds * 50)
        for step in range(steps):
            command = list(begin)
            command[5] += AMPLITUDE * math.sin(2 * math.pi * step / 50 / PERIOD)
            self.out.publish(Float64MultiArray(data=command))
            end = self.get_clock().now() + Duration(seconds=0.02)
            while self.get_clock().now() < end:
                rclpy.spin_once(self, timeout_sec=0.005)
            low = min(low, self.where[JOINTS[5]])
            high = max(high, self.where[JOINTS[5]])
        self.get_logger().info(f"wrist_3 moved within {high - low:.3f} rad")


def main():
    rclpy.init()
    node = Wiggle()
    node.use_forward_controller()
    node.wiggle(8.0)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
