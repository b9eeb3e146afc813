#!/usr/bin/env python3
# UR5e with a barcode scanner: reads the labels of a pallet, row by row in snake order (ROS 2).
# Everything happens in a timer of 50 ms: state machine over /joint_states, nothing blocks.
import enum

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")
IDLE_POSE = (0.0, -1.6, 1.5, -1.47, -1.57, 0.0)
FIRST = (-0.40, -1.45, 1.75, -1.87, -1.57, -0.40)     # over the label in row 0, column 0
PER_COLUMN = (0.40, 0.0, 0.0, 0.0, 0.0, 0.40)
PER_ROW = (0.0, 0.28, -0.40, 0.12, 0.0, 0.0)


class State(enum.Enum):
    MOVING = "moving"
    DWELL = "dwell"
    READING = "reading"
    CLOSING = "closing"
    FINISHED = "finished"


class ScanCell(Node):
    def __init__(self):
        super().__init__("scan_cell")
        self.declare_parameters("", [("dwell", 0.5), ("rows", 1), ("columns", 1), ("speed", 0.5),
                                     ("tolerance", 0.004)])
        value = lambda name: self.get_parameter(name).value
        self.dwell, self.speed, self.tolerance = value("dwell"), value("speed"), value("tolerance")
        self.route = list(self.snake(value("rows"), value("columns")))
        self.target, self.station = None, None
        self.state, self.since = None, None
        self.current = None
        self.pending, self.retries, self.codes = None, 0, {}

        self.create_subscription(JointState, "/joint_states", self.on_joints, 10)
        self.command = self.create_publisher(
            JointTrajectory, "/scaled_joint_trajectory_controller/joint_trajectory", 1)
        self.codes_out = self.create_publisher(String, "/mes/codes", 10)
        self.reader = self.create_client(Trigger, "/scanner/read")
        self.closer = self.create_client(Trigger, "/mes/close_pallet")
        self.create_timer(0.05, self.tick)

    @staticmethod
    def snake(rows, columns):
        for row in range(rows):
            order = range(columns) if row % 2 == 0 else reversed(range(columns))
            for column in order:
                yield row, column

    def on_joints(self, message):
        where = dict(zip(message.name, message.position))
        self.current = [where[j] for j in JOINTS]

    def now(self):
        return self.get_clock().now().nanoseconds * 1e-9

    def enter(self, state):
        self.state, self.since = state, self.now()

    def drive(self, target):
        self.target = target
        way = max(abs(a - b) for a, b in zip(target, self.current))
        seconds = max(0.5, way / self.speed * 1.5)
        message = JointTrajectory(joint_names=list(JOINTS))
        point = JointTrajectoryPoint(positions=list(target), velocities=[0.0] * 6)
        point.time_from_start = Duration(sec=int(seconds), nanosec=int(seconds % 1 * 1e9))
        message.points.append(point)
        self.command.publish(message)
        self.enter(State.MOVING)

    def next_station(self):
        self.retries = 0
        if self.route:
            self.station = self.route.pop(0)
            row, column = self.station
            self.drive([f + row * r + column * c for f, r, c in zip(FIRST, PER_ROW, PER_COLUMN)])
        else:
            self.station = None
            self.drive(IDLE_POSE)

    def arrived(self):
        return max(abs(a - b) for a, b in zip(self.target, self.current)) < self.tolerance

    # ------------------------------------------------------------ one step
    def tick(self):
        if self.current is None:
            return
        if self.state is None:
            self.next_station()
        elif self.state is State.MOVING and self.arrived():
            self.enter(State.DWELL)
        elif self.state is State.DWELL and self.now() - self.since >= self.dwell:
            if self.station is None:
                self.pending = self.closer.call_async(Trigger.Request())
                self.enter(State.CLOSING)
            else:
                self.pending = self.reader.call_async(Trigger.Request())
                self.enter(State.READING)
        elif self.state is State.READING and self.pending.done():
            self.on_code(self.pending.result())
        elif self.state is State.CLOSING and self.pending.done():
            self.enter(State.FINISHED)
            raise SystemExit

    def on_code(self, answer):
        if answer.success:
            self.codes[self.station] = answer.message
            self.codes_out.publish(String(data="%d/%d %s" % (*self.station, answer.message)))
            self.next_station()
        elif self.retries < 2:
            self.retries += 1
            self.enter(State.DWELL)
        else:
            self.get_logger().error(f"no label at {self.station}")
            self.next_station()


def main():
    rclpy.init()
    node = ScanCell()
    try:
        rclpy.spin(node)
    except SystemExit:
        node.get_logger().info(f"pallet: {node.codes}")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
