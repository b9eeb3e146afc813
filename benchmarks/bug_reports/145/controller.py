#!/usr/bin/env python3
"""An xArm 6 visits three points above its table by the services of xarm_api: millimetres and radians."""
import math

import rclpy
from rclpy.node import Node
from xarm_msgs.srv import GetFloat32List, MoveCartesian, SetInt16, SetInt16ById

# x, y, z [mm], roll, pitch, yaw [rad]
POINTS = [
    ("front", [300.0, 0.0, 250.0, 3.14, 0.0, 0.0]),
    ("left", [300.0, 80.0, 250.0, 3.14, 0.1, 0.2]),
    ("front", [300.0, 0.0, 250.0, 3.14, 0.0, 0.0]),
]
SPEED = 50.0        # [mm/s]
ACCELERATION = 500.0


def angle_between(a, b):
    return abs(math.remainder(a - b, 2.0 * math.pi))


class Tool(Node):
    def __init__(self):
        super().__init__("xarm_points")
        self.enable = self.create_client(SetInt16ById, "/xarm/motion_enable")
        self.mode = self.create_client(SetInt16, "/xarm/set_mode")
        self.state = self.create_client(SetInt16, "/xarm/set_state")
        self.line = self.create_client(MoveCartesian, "/xarm/set_position")
        self.where = self.create_client(GetFloat32List, "/xarm/get_position")

    def ask(self, client, request):
        client.wait_for_service()
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        answer = future.result()
        if answer.ret != 0:
            raise RuntimeError(f"{client.srv_name}: {answer.ret} {answer.message}")
        return answer

    def start(self):
        self.ask(self.enable, SetInt16ById.Request(id=8, data=1))
        self.ask(self.mode, SetInt16.Request(data=0))
        self.ask(self.state, SetInt16.Request(data=0))

    def go(self, name, pose):
        request = MoveCartesian.Request()
        request.pose = pose
        request.speed = SPEED
        request.acc = ACCELERATION
        request.mvtime = 0.0
        request.wait = True
        request.timeout = 30.0
        answer = self.ask(self.line, request)
        now = list(self.ask(self.where, GetFloat32List.Request()).datas)
        off = math.dist(now[:3], pose[:3])
        turned = max(angle_between(a, b) for a, b in zip(now[3:6], pose[3:6]))
        self.get_logger().info(
            f"{name}: ret {answer.ret}, {off:.1f} mm and {turned:.3f} rad off")
        if off > 2.0 or turned > 0.02:
            raise RuntimeError(f"the tool is not at {name}")


def main():
    rclpy.init()
    node = Tool()
    node.start()
    for name, pose in POINTS:
        node.go(name, pose)
    node.get_logger().info("all points visited")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
