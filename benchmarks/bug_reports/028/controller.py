#!/usr/bin/env python3
"""Moves a Doosan M1013 to two poses by the service move_joint (ROS 2 Humble)."""
import rclpy
from dsr_msgs2.srv import MoveJoint
from rclpy.node import Node


class Doosan(Node):
    def __init__(self):
        super().__init__("m1013_two_poses")
        self.client = self.create_client(MoveJoint, "/dsr01/motion/move_joint")
        self.client.wait_for_service()

    def move(self, degrees):
        request = MoveJoint.Request()
        request.pos = degrees
        request.vel = 30.0
        request.acc = 60.0
        request.time = 0.0
        request.radius = 0.0
        request.mode = 0
        request.blend_type = 0
        request.sync_type = 0
        future = self.client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result().success


def main():
    rclpy.init()
    node = Doosan()
    node.get_logger().info(f"first: {node.move([0.0, 0.0, 90.0, 0.0, 90.0, 0.0])}")
    node.get_logger().info(f"second: {node.move([30.0, 0.0, 90.0, 0.0, 90.0, 0.0])}")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
