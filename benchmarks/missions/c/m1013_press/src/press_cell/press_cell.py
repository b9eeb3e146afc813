#!/usr/bin/env python3
"""Presses two dowel pins with a C-frame press on a Doosan M1013 (dsr_msgs2 services, degrees and mm; ROS 2)."""
import threading
from collections import OrderedDict

import rclpy
from dsr_msgs2.srv import MoveJoint, MoveLine, MoveWait
from press_msgs.srv import PressPin
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float32, String, UInt32
from std_srvs.srv import SetBool

MV_MOD_ABS, MV_MOD_REL = 0, 1
DR_BASE, DR_TOOL = 0, 1

HOME = [0.0, 0.0, 90.0, 0.0, 90.0, 0.0]
STATIONS = OrderedDict([
    ("left", dict(pin=3301, posj=[-21.55, 11.73, 103.52, 0.0, 64.76, -21.55], force_kn=12.5, dwell_ms=400)),
    ("right", dict(pin=3302, posj=[15.31, 11.73, 103.52, 0.0, 64.78, 15.31], force_kn=9.0, dwell_ms=250)),
])
PLUNGE_MM = 60.0


class Doosan:
    """Blocking calls on top of a node that another thread spins."""

    def __init__(self, node, prefix="/dsr01"):
        self._node = node
        self._joint = node.create_client(MoveJoint, prefix + "/motion/move_joint")
        self._line = node.create_client(MoveLine, prefix + "/motion/move_line")
        for client in (self._joint, self._line):
            while not client.wait_for_service(timeout_sec=1.0):
                node.get_logger().info("waiting for the controller")

    def movej(self, posj, vel=45.0, acc=60.0):
        request = MoveJoint.Request(pos=[float(v) for v in posj], vel=vel, acc=acc, mode=MV_MOD_ABS)
        return self.call(self._joint, request).success

    def moveby(self, dz, vel=60.0, acc=200.0):
        request = MoveLine.Request(pos=[0.0, 0.0, float(dz), 0.0, 0.0, 0.0], vel=[vel, 30.0], acc=[acc, 60.0],
                                   ref=DR_BASE, mode=MV_MOD_REL)
        return self.call(self._line, request).success

    def call(self, client, request, timeout=20.0):
        ready = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: ready.set())
        if not ready.wait(timeout):
            raise TimeoutError(client.srv_name)
        return future.result()


class PressCell(Node):
    def __init__(self):
        super().__init__("press_cell")
        self.force = self.create_publisher(Float32, "/press/preset_kn", 10)
        self.result = self.create_publisher(String, "/press/result", 10)
        self.pressed = self.create_publisher(UInt32, "/press/pins", 10)
        self.press = self.create_client(PressPin, "/press/run")
        self.guard = self.create_client(SetBool, "/guard/lock")
        self.log = []

    def cycle(self, robot):
        robot.call(self.guard, SetBool.Request(data=True))
        robot.movej(HOME)
        for name, station in STATIONS.items():
            self.station(robot, name, **station)
        robot.movej(HOME)
        robot.call(self.guard, SetBool.Request(data=False))
        self.pressed.publish(UInt32(data=len(self.log)))

    def station(self, robot, name, pin, posj, force_kn, dwell_ms):
        self.force.publish(Float32(data=force_kn))
        if not robot.movej(posj):
            raise RuntimeError(f"station {name} is out of reach")
        robot.moveby(-PLUNGE_MM)
        answer = robot.call(self.press, PressPin.Request(pin_id=pin, force_kn=force_kn, dwell_ms=dwell_ms))
        robot.moveby(PLUNGE_MM)
        good = answer.ok and answer.peak_kn >= 0.9 * force_kn
        if good:
            self.log.append(pin)
        self.result.publish(String(data=f"{name} {pin} {'OK' if good else 'NOK'}"))


def main():
    rclpy.init()
    cell = PressCell()
    executor = SingleThreadedExecutor()
    executor.add_node(cell)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    try:
        cell.cycle(Doosan(cell))
    finally:
        executor.shutdown()
        rclpy.try_shutdown()
        thread.join(1.0)


if __name__ == "__main__":
    main()
