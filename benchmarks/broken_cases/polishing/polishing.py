"""Polish in strokes with a UR5e, by a topic of set-points and a timer (ROS 2)."""

import math

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray

START = [0.0, -1.5, 1.6, -1.7, -1.57, 0.0]
PERIOD, STROKES, STROKE_S = 0.02, 3, 2.0


class Polishing(Node):
    def __init__(self):
        super().__init__("polishing")
        self.publisher = self.create_publisher(
            Float64MultiArray, "/forward_position_controller/commands", 10
        )
        self.ticks = 0
        self.timer = self.create_timer(PERIOD, self.tick)
        self.is_done = False

    def tick(self):
        at = self.ticks * PERIOD
        if at >= STROKES * STROKE_S:
            self.finish()
            return
        self.stroke(at)
        self.ticks += 1

    def stroke(self, at):
        swing = 0.3 * math.sin(2.0 * math.pi * at / STROKE_S) ** 2
        self.command([START[0] + swing, *START[1:]])

    def finish(self):
        if self.is_done:
            return
        self.timer.cancel()
        self.command([-0.2, -1.5, 1.6, -1.7, -1.57, 0.0])
        self.is_done = True

    def command(self, positions):
        self.publisher.publish(Float64MultiArray(data=positions))


def main():
    rclpy.init()
    node = Polishing()
    rclpy.spin(node)


if __name__ == "__main__":
    main()
