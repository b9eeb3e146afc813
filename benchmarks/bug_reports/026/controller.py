#!/usr/bin/env python3
"""Starts a turn of a Doosan M1013's base and stops it half way (ROS 2 Humble)."""
import math
import time

import rclpy
from dsr_msgs2.srv import MoveJoint, MoveStop
from rclpy.node import Node
from sensor_msgs.msg import JointState


class HalfTurn(Node):
    def __init__(self):
        super().__init__("m1013_half_turn")
        self.joint = None
        self.move = self.create_client(MoveJoint, "/dsr01/motion/move_joint")
        self.halt = self.create_client(MoveStop, "/dsr01/motion/move_stop")
        self.move.wait_for_service()
        self.halt.wait_for_service()
        self.create_subscription(JointState, "/dsr01/joint_states", self.on_state, 10)

    def on_state(self, message):
        self.joint = message.position[message.name.index("joint_1")]

    def call(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def turn(self, degrees, sync_type):
        request = MoveJoint.Request()
        request.pos = [degrees, 0.0, 90.0, 0.0, 90.0, 0.0]
        request.vel = 20.0
        request.acc = 40.0
        request.sync_type = sync_type
        return self.call(self.move, request)


def main():
    rclpy.init()
    node = HalfTurn()
    node.turn(0.0, 0)
    node.turn(90.0, 0)
    time.sleep(2.0)
    node.call(node.halt, MoveStop.Request(stop_mode=1))
    node.joint = None
    while node.joint is None:
        rclpy.spin_once(node)
    node.get_logger().info(f"stopped at {math.degrees(node.joint):.0f}")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
