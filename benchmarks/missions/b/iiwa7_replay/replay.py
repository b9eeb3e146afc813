#!/usr/bin/env python3
"""Replays a recorded teleoperation session on the iiwa: a spray pass and a photo (ROS 2).

The recording has joint angles every 0.25 s and marks; in between we interpolate and stream
set-points at the rate of the controller.
"""
import bisect
import csv
import os
from dataclasses import dataclass, field

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"lbr_A{i}" for i in range(1, 8)]
RATE = 50.0
LEAD_IN = 3.0           # s, to the first sample


@dataclass
class Recording:
    times: list = field(default_factory=list)
    samples: list = field(default_factory=list)
    marks: list = field(default_factory=list)

    @classmethod
    def load(cls, path):
        rec = cls()
        with open(path, newline="") as stream:
            for row in csv.DictReader(stream):
                rec.times.append(float(row["t"]))
                rec.samples.append([float(row[f"A{i}"]) for i in range(1, 8)])
                if row["mark"]:
                    rec.marks.append((rec.times[-1], row["mark"]))
        return rec

    @property
    def length(self):
        return self.times[-1]

    def at(self, t):
        """Joint angles at time t, straight between two samples."""
        if t >= self.length:
            return self.samples[-1]
        k = bisect.bisect_right(self.times, t)
        t0, t1 = self.times[k - 1], self.times[k]
        u = (t - t0) / (t1 - t0)
        return [a + u * (b - a) for a, b in zip(self.samples[k - 1], self.samples[k])]


class Replay(Node):
    def __init__(self):
        super().__init__("session_replay")
        path = self.declare_parameter("session", "session_17.csv").value
        self.speed = self.declare_parameter("speed", 1.0).value
        self.rec = Recording.load(os.path.join(os.path.dirname(os.path.abspath(__file__)), path))
        self.pub = self.create_publisher(
            JointTrajectory, "/joint_trajectory_controller/joint_trajectory", 1)
        self.log = self.create_publisher(String, "/replay/log", 10)
        group = ReentrantCallbackGroup()
        self.tools = {
            mark: self.create_client(Trigger, f"/tool/{mark}", callback_group=group)
            for mark in ("spray_on", "spray_off", "photo")
        }
        self.create_subscription(JointState, "/joint_states", self.on_state, 1)
        self.actual = None
        self.pending = list(self.rec.marks)
        self.t0 = None
        self.done = False
        self.timer = None

    def on_state(self, msg):
        if self.actual is None:
            self.actual = dict(zip(msg.name, msg.position))
            self.lead_in()

    def send(self, joints, seconds):
        msg = JointTrajectory(joint_names=JOINTS)
        point = JointTrajectoryPoint(positions=list(joints))
        point.time_from_start = Duration(sec=int(seconds), nanosec=int((seconds % 1.0) * 1e9))
        msg.points.append(point)
        self.pub.publish(msg)

    def lead_in(self):
        self.get_logger().info("moving to the first sample")
        self.send(self.rec.samples[0], LEAD_IN)
        self.start_timer = self.create_timer(LEAD_IN + 0.5, self.start)

    def start(self):
        self.start_timer.cancel()
        self.t0 = self.get_clock().now()
        self.timer = self.create_timer(1.0 / RATE, self.tick)
        self.log.publish(String(data="start"))

    def tick(self):
        t = (self.get_clock().now() - self.t0).nanoseconds * 1e-9 * self.speed
        while self.pending and self.pending[0][0] <= t:
            _, mark = self.pending.pop(0)
            self.tools[mark].call_async(Trigger.Request())
            self.log.publish(String(data=mark))
        self.send(self.rec.at(t + 1.0 / RATE), 1.0 / RATE)
        if t > self.rec.length + 0.5:
            self.timer.cancel()
            self.log.publish(String(data="end"))
            self.done = True


def main():
    rclpy.init()
    node = Replay()
    while rclpy.ok() and not node.done:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
