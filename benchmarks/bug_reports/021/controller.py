#!/usr/bin/env python3
"""Brings an xArm 6 above a drop place by the services of xarm_api."""
import sys

import rclpy
from rclpy.node import Node
from xarm_msgs.srv import MoveCartesian, SetInt16, SetInt16ById


class Drop(Node):
    def __init__(self):
        super().__init__("xarm6_drop")
        self.enable = self.create_client(SetInt16ById, "/xarm/motion_enable")
        self.mode = self.create_client(SetInt16, "/xarm/set_mode")
        self.state = self.create_client(SetInt16, "/xarm/set_state")
        self.position = self.create_client(MoveCartesian, "/xarm/set_position")
        for client in (self.enable, self.mode, self.state, self.position):
            client.wait_for_service()

    def call(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def prepare(self):
        self.call(self.enable, SetInt16ById.Request(id=8, data=1))
        self.call(self.mode, SetInt16.Request(data=0))
        self.call(self.state, SetInt16.Request(data=0))

    def move(self, x, y, z):
        request = MoveCartesian.Request()
        request.pose = [x, y, z]
        request.speed = 100.0
        request.acc = 500.0
        request.wait = True
        return self.call(self.position, request).ret


def main():
    rclpy.init()
    node = Drop()
    node.prepare()
    ret = node.move(300.0, 0.0, 250.0)
    if ret != 0:
        node.get_logger().error(f"set_position returned {ret}")
        rclpy.shutdown()
        sys.exit(1)
    node.get_logger().info("at the drop")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
