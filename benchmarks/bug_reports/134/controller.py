#!/usr/bin/env python3
"""A Panda waves by set-points from a timer of 10 Hz, whose callback takes 40 ms each time."""
import math
import time

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
PERIOD = 0.1        # [s]
WORK = 0.04         # [s] that a callback needs
TICKS = 60
WIDE = 0.3          # [rad]


class Waver(Node):
    def __init__(self):
        super().__init__("panda_waves")
        self.begin = None
        self.times = []
        self.setpoint = self.create_publisher(
            JointTrajectory, "/panda_arm_controller/joint_trajectory", 10)
        self.states = self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.timer = None

    def on_state(self, msg):
        if self.begin is None:
            where = dict(zip(msg.name, msg.position))
            self.begin = [where[name] for name in JOINTS]

    def start(self):
        while self.begin is None:
            rclpy.spin_once(self, timeout_sec=0.5)
        self.destroy_subscription(self.states)
        self.timer = self.create_timer(PERIOD, self.tick)

    def tick(self):
        self.times.append(self.get_clock().now().nanoseconds * 1e-9)
        phase = 2.0 * math.pi * len(self.times) / TICKS
        where = list(self.begin)
        where[0] += WIDE * math.sin(phase)
        self.setpoint.publish(JointTrajectory(
            joint_names=JOINTS,
            points=[JointTrajectoryPoint(
                positions=where, time_from_start=Duration(nanosec=int(PERIOD * 1e9)))]))
        time.sleep(WORK)      # looks at the face of the visitor
        if len(self.times) == TICKS:
            self.timer.cancel()


def main():
    rclpy.init()
    node = Waver()
    node.start()
    while len(node.times) < TICKS:
        rclpy.spin_once(node, timeout_sec=1.0)
    gaps = [b - a for a, b in zip(node.times, node.times[1:])]
    mean = sum(gaps) / len(gaps)
    node.get_logger().info(
        f"{TICKS} ticks, mean {mean:.3f} s, longest {max(gaps):.3f} s, "
        f"shortest {min(gaps):.3f} s")
    if abs(mean - PERIOD) > 0.005:
        raise RuntimeError("the timer lost its period")
    time.sleep(1.0)
    node.get_logger().info("waved")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
