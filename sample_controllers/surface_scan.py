#!/usr/bin/env python3
"""Sweep a sensor over a workpiece with a UR5e, line by line, until the node is stopped (ROS 2).

Publishes a short trajectory for the arm's controller each time the previous one must be done.
"""

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
]

# The corners of the scan; a line is driven there and back.
LINES = {
    "front": ([-0.45, -1.35, 1.75, -1.97, -1.57, 0.0], [0.45, -1.35, 1.75, -1.97, -1.57, 0.0]),
    "back": ([-0.35, -1.05, 1.30, -1.82, -1.57, 0.0], [0.35, -1.05, 1.30, -1.82, -1.57, 0.0]),
}


class SurfaceScan(Node):
    """Streams the lines of the scan to the trajectory controller of the UR5e."""

    def __init__(self):
        super().__init__("ur5e_surface_scan")
        self.declare_parameter("controller", "scaled_joint_trajectory_controller")
        self.declare_parameter("line_time", 2.0)
        controller = self.get_parameter("controller").value
        self.line_time = self.get_parameter("line_time").value

        self.publisher = self.create_publisher(
            JointTrajectory, f"/{controller}/joint_trajectory", 10
        )
        self.step = 0
        self.timer = self.create_timer(2.0 * self.line_time + 0.5, self.on_timer)

    def on_timer(self):
        """Begin the next line."""
        if self.step % 2 == 0:
            self.scan_front()
        else:
            self.scan_back()
        self.step += 1

    def scan_front(self):
        """Scan the line next to the robot."""
        self.publish_line(*LINES["front"])

    def scan_back(self):
        """Scan the line far from the robot."""
        self.publish_line(*LINES["back"])

    def publish_line(self, start, end):
        message = JointTrajectory()
        message.joint_names = JOINTS
        for number, positions in enumerate((start, end), start=1):
            point = JointTrajectoryPoint()
            point.positions = positions
            point.time_from_start = to_duration(number * self.line_time)
            message.points.append(point)
        self.publisher.publish(message)


def to_duration(seconds):
    whole = int(seconds)
    return Duration(sec=whole, nanosec=int((seconds - whole) * 1e9))


def main():
    rclpy.init()
    node = SurfaceScan()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
