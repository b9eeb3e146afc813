#!/usr/bin/env python3
"""Checks that the controller of a UR5e is active, then brings the arm to its working pose."""
import rclpy
from builtin_interfaces.msg import Duration
from controller_manager_msgs.srv import ListControllers
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

CONTROLLER = "scaled_joint_trajectory_controller"
JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
WORKING = [0.4, -1.3, 1.7, -1.97, -1.57, 0.0]


class CarefulStart(Node):
    def __init__(self):
        super().__init__("ur5e_careful_start")
        self.manager = self.create_client(ListControllers, "/controller_manager/list_controllers")
        self.manager.wait_for_service()
        self.publisher = self.create_publisher(
            JointTrajectory, f"/{CONTROLLER}/joint_trajectory", 10)
        self.timer = self.create_timer(1.0, self.on_timer)

    def on_timer(self):
        self.timer.cancel()
        self.get_logger().info("asking the controller manager")
        response = self.manager.call(ListControllers.Request())
        active = [c.name for c in response.controller if c.state == "active"]
        if CONTROLLER not in active:
            self.get_logger().error(f"{CONTROLLER} is not active")
            return
        self.get_logger().info("sending the trajectory")
        message = JointTrajectory(joint_names=JOINTS)
        message.points.append(JointTrajectoryPoint(
            positions=WORKING, time_from_start=Duration(sec=4)))
        self.publisher.publish(message)


def main():
    rclpy.init()
    node = CarefulStart()
    rclpy.spin(node)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
