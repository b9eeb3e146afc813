#!/usr/bin/env python3
"""Seal a lid: a UR10e draws a bead around it. One generator is the whole programme; a timer resumes it (ROS 2)."""
import math

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from std_msgs.msg import Float32, Int32
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import ur_kin

NAMES = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
SEED = [-0.5140, -1.4003, 2.2203, -2.3899, -1.5701, 1.0560]
DOWN = np.diag([-1.0, 1.0, -1.0])
PARK = [-0.4, -1.6, 2.0, -1.97, -1.57, 1.17]

LID_X, LID_Y = (0.62, 0.78), (-0.15, 0.10)
BEAD_Z = 0.25          # of the flange; the nozzle is 0.2 m long
CLEAR = 0.08
BEAD_SPEED = 0.08      # m/s
SECTION_MM2 = 3.2      # of the bead
BEAD_RUNS = 1


def corners():
    (x0, x1), (y0, y1) = LID_X, LID_Y
    return [(x0, y0), (x0, y1), (x1, y1), (x1, y0), (x0, y0)]


class Dispenser(Node):
    def __init__(self):
        super().__init__("dispenser")
        self.track = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 1)
        self.flow = self.create_publisher(Float32, "/doser/flow_ml_min", 10)
        self.heat = self.create_publisher(Float32, "/doser/heater_c", 10)
        self.bead = self.create_publisher(Int32, "/doser/bead_mm", 10)
        self.valve = self.create_client(SetBool, "/doser/valve")
        self.valve.wait_for_service()
        self.q = np.array(SEED)
        self.finished = False
        self.programme = self.seal()
        self.wake = self.create_timer(0.5, self.resume)

    def resume(self):
        """Runs the programme to its next pause."""
        self.destroy_timer(self.wake)
        try:
            pause = next(self.programme)
        except StopIteration:
            self.finished = True
            return
        self.wake = self.create_timer(pause, self.resume)

    # --- the programme -------------------------------------------------------------------------
    def seal(self):
        self.heat.publish(Float32(data=62.0))
        yield self.send([(PARK, 2.5)]) + 0.3
        first = corners()[0]
        yield self.send([(self.solve(*first, BEAD_Z + CLEAR), 2.0), (self.solve(*first, BEAD_Z), 3.2)]) + 0.3
        for _ in range(BEAD_RUNS):
            self.flow.publish(Float32(data=self.flow_rate()))
            self.open_valve(True)
            yield 0.2
            yield self.send(self.rim()) + 0.1
            self.open_valve(False)
            self.flow.publish(Float32(data=0.0))
        yield self.send([(self.solve(*first, BEAD_Z + CLEAR), 1.2)]) + 0.3
        self.bead.publish(Int32(data=round(1000 * self.length())))
        yield self.send([(PARK, 2.5)]) + 0.3
        self.heat.publish(Float32(data=25.0))

    def rim(self):
        """The way around the lid in steps of about 20 mm at constant speed."""
        clock, points = 0.0, []
        for (xa, ya), (xb, yb) in zip(corners(), corners()[1:]):
            length = math.hypot(xb - xa, yb - ya)
            steps = math.ceil(length / 0.02)
            for i in range(1, steps + 1):
                clock += length / steps / BEAD_SPEED
                share = i / steps
                points.append((self.solve(xa + (xb - xa) * share, ya + (yb - ya) * share, BEAD_Z), clock))
        return points

    def length(self):
        return sum(math.dist(a, b) for a, b in zip(corners(), corners()[1:])) * BEAD_RUNS

    def flow_rate(self):
        """ml/min for the section at the speed of the bead."""
        return SECTION_MM2 * BEAD_SPEED * 1000.0 * 60.0 / 1000.0

    # --- helpers -------------------------------------------------------------------------------
    def open_valve(self, on):
        self.valve.call_async(SetBool.Request(data=on))

    def solve(self, x, y, z):
        self.q = ur_kin.inverse((x, y, z), DOWN, self.q)
        return self.q.tolist()

    def send(self, timed):
        message = JointTrajectory(joint_names=NAMES)
        for joints, at in timed:
            point = JointTrajectoryPoint(positions=[float(v) for v in joints])
            point.time_from_start = Duration(sec=int(at), nanosec=int(at % 1 * 1e9))
            message.points.append(point)
        self.track.publish(message)
        return timed[-1][1]


def main():
    rclpy.init()
    node = Dispenser()
    while not node.finished:
        rclpy.spin_once(node)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
