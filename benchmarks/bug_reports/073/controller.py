#!/usr/bin/env python3
"""Two nodes in one process: one picks targets, the other moves an FR3 to them (ROS 2)."""
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"fr3_joint{i}" for i in range(1, 8)]
REST = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


class Targets(Node):
    def __init__(self):
        super().__init__("targets")
        self.publisher = self.create_publisher(Float64, "/cell/target", qos_profile_sensor_data)
        self.angles = [0.5, -0.5, 0.5]
        self.timer = self.create_timer(5.0, self.on_timer)

    def on_timer(self):
        if not self.angles:
            raise SystemExit
        self.publisher.publish(Float64(data=self.angles.pop(0)))


class Mover(Node):
    def __init__(self):
        super().__init__("mover")
        self.command = self.create_publisher(
            JointTrajectory, "/fr3_arm_controller/joint_trajectory", 10)
        self.create_subscription(Float64, "/cell/target", self.on_target, 10)

    def on_target(self, message):
        self.get_logger().info(f"target {message.data}")
        trajectory = JointTrajectory(joint_names=JOINTS)
        trajectory.points.append(JointTrajectoryPoint(
            positions=[message.data] + REST[1:], time_from_start=Duration(sec=4)))
        self.command.publish(trajectory)


def main():
    rclpy.init()
    executor = SingleThreadedExecutor()
    for node in (Targets(), Mover()):
        executor.add_node(node)
    try:
        executor.spin()
    except SystemExit:
        rclpy.shutdown()


if __name__ == "__main__":
    main()
