#!/usr/bin/env python3
"""Drives an xArm 6 through two joint poses at a slow speed (xarm_api, ROS 2)."""
import rclpy
from rclpy.node import Node
from xarm_msgs.srv import MoveJoint, SetInt16, SetInt16ById

FIRST = [0.0, -0.4, -0.4, 0.0, 0.8, 0.0]
SECOND = [0.4, -0.5, -0.5, 0.0, 0.9, 0.0]


def call(node, kind, name, request):
    client = node.create_client(kind, name)
    client.wait_for_service()
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future)
    return future.result()


def main():
    rclpy.init()
    node = Node("xarm6_two_poses")
    call(node, SetInt16ById, "/xarm/motion_enable", SetInt16ById.Request(id=8, data=1))
    call(node, SetInt16, "/xarm/set_mode", SetInt16.Request(data=0))
    call(node, SetInt16, "/xarm/set_state", SetInt16.Request(data=0))
    for name, angles in (("first", FIRST), ("second", SECOND)):
        request = MoveJoint.Request()
        request.angles = angles
        request.speed = 0.35
        request.acc = 5.0
        request.wait = True
        response = call(node, MoveJoint, "/xarm/set_servo_angle", request)
        node.get_logger().info(f"{name} pose, ret {response.ret}")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
