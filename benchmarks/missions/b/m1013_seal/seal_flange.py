#!/usr/bin/env python3
# Sealant on the flange of a pump housing, M1013.
# Ported from kinetic (seal_flange_node, 2018) to ROS 2; keep the order of the calls, the dosing
# unit is picky.
import sys

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from legacy_arm import LegacyArm, shifted

HOME = [0.0, 0.0, 1.571, 0.0, 1.571, 0.0]
PURGE = [-0.9, 0.1, 1.75, 0.0, 1.29, 0.0]
START = [0.0, 0.1, 1.9, 0.0, 1.14, 0.0]

APPROACH = 0.08        # m above the flange
FLANGE_X = 0.12
FLANGE_Y = 0.16
INSET = 0.015          # of the second bead
BEADS = 2
SLOW = 3.0


class SealNode(Node):
    def __init__(self):
        super().__init__("seal_flange_node")
        self.inset = self.declare_parameter("inset", INSET).value
        self.beads = self.declare_parameter("beads", BEADS).value
        self.svc = {}
        for name in ("dispenser/purge", "dispenser/open", "dispenser/close", "plc/part_done"):
            self.svc[name] = self.create_client(Trigger, "/" + name)
            self.svc[name].wait_for_service()
        self.length_pub = self.create_publisher(Float32, "/seal/bead_length", 10)
        self.arm = LegacyArm(self)

    def call(self, name):
        future = self.svc[name].call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self, future)
        if not future.result().success:
            raise RuntimeError(name + ": " + future.result().message)

    def corners(self, origin, number):
        d = number * self.inset
        x0, y0 = d, d
        x1, y1 = FLANGE_X - d, FLANGE_Y - d
        loop = [(x0, y0), (x0, y1), (x1, y1), (x1, y0), (x0, y0)]
        return [shifted(origin, x, y, -APPROACH) for x, y in loop]

    def bead(self, origin, number):
        path = self.corners(origin, number)
        self.arm.follow([shifted(path[0], dz=APPROACH), path[0]])
        self.call("dispenser/open")
        self.arm.follow(path[1:], SLOW)
        self.call("dispenser/close")
        self.arm.follow([shifted(path[-1], dz=APPROACH)])
        d = number * self.inset
        self.length_pub.publish(Float32(data=2 * (FLANGE_X + FLANGE_Y - 4 * d)))

    def run(self):
        self.arm.go(HOME, 1.5)
        self.arm.go(PURGE, 2.0)
        self.call("dispenser/purge")
        self.arm.go(START, 2.0)
        origin = self.arm.where()
        for number in range(self.beads):
            self.bead(origin, number)
        self.call("plc/part_done")
        self.arm.go(HOME, 2.0)


def main():
    rclpy.init(args=sys.argv)
    node = SealNode()
    try:
        node.run()
    finally:
        node.destroy_node()
        rclpy.shutdown()


if __name__ == "__main__":
    main()
