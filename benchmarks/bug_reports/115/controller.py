#!/usr/bin/env python3
"""Stream a slow swing of the base to the trajectory controller of a UR5e, 20 times a second."""
import math
import time

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
RATE = 20.0
SWING = 0.4
SECONDS = 8.0


class Stream(Node):
    def __init__(self):
        super().__init__("stamped_stream")
        self.begin = None
        self.now = {}
        self.step = 0
        self.create_subscription(JointState, "/joint_states", self.on_state, 10)
        self.out = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 10)
        self.timer = self.create_timer(1.0 / RATE, self.tick)

    def on_state(self, msg):
        self.now = dict(zip(msg.name, msg.position))
        if self.begin is None and all(name in self.now for name in JOINTS):
            self.begin = [self.now[name] for name in JOINTS]

    def solve(self):
        """The set-point of this tick; the solver of the real cell takes a few milliseconds."""
        time.sleep(0.004)
        positions = list(self.begin)
        positions[0] += SWING * math.sin(2 * math.pi * self.step / RATE / SECONDS)
        return positions

    def tick(self):
        if self.begin is None:
            return
        message = JointTrajectory()
        message.header.stamp = self.get_clock().now().to_msg()
        message.joint_names = JOINTS
        message.points = [JointTrajectoryPoint(positions=self.solve())]
        self.out.publish(message)
        self.step += 1
        if self.step == int(SECONDS * RATE / 4):
            moved = self.now[JOINTS[0]] - self.begin[0]
            self.get_logger().info(f"a quarter: the base has turned by {moved:.3f} rad")

    def finished(self):
        return self.step >= SECONDS * RATE


def main():
    rclpy.init()
    node = Stream()
    while not node.finished():
        rclpy.spin_once(node, timeout_sec=1.0)
    node.get_logger().info(f"{node.step} set-points sent")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
