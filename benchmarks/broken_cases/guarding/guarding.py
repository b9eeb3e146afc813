"""Walk through stations by a timer, one step at a time (ROS 2, a machine of states)."""

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from std_msgs.msg import Bool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["axis_1", "axis_2", "axis_3", "axis_4", "axis_5", "axis_6"]
STATIONS = {
    "door": [1.2, 0.1, 1.0, 0.6, 0.0, 0.0],
    "window": [-0.6, 0.3, 1.1, 0.5, 0.4, 0.0],
    "desk": [0.2, 0.6, 0.8, 0.4, 0.0, 0.3],
}


class Guarding(Node):
    def __init__(self):
        super().__init__("guarding")
        self.arm = self.create_publisher(JointTrajectory, "/arm_controller/joint_trajectory", 10)
        self.create_subscription(Bool, "/gate/closed", self.on_gate, 10)
        self.is_closed = False
        self.left = list(STATIONS)
        self.timer = self.create_timer(3.0, self.on_timer)

    def on_gate(self, message):
        self.is_closed = message.data

    def on_timer(self):
        if not self.is_closed:
            self.get_logger().info("the gate is open")
            return
        if not self.left:
            self.home()
            self.timer.cancel()
            return
        self.visit(self.left.pop(0))

    def visit(self, name):
        self.send(STATIONS[name], 2)

    def home(self):
        self.send([0.0, 0.0, 1.0, 0.5, 0.0, 0.0], 2)

    def send(self, posture, seconds):
        message = JointTrajectory(joint_names=JOINTS)
        point = JointTrajectoryPoint(positions=posture)
        point.time_from_start = Duration(sec=seconds)
        message.points.append(point)
        self.arm.publish(message)


def main():
    rclpy.init()
    rclpy.spin(Guarding())


if __name__ == "__main__":
    main()
