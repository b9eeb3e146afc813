#!/usr/bin/env python3
"""A UR5e goes home by its trajectory controller, then hands over to position commands and trims the wrist."""
import time

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.srv import SwitchController
from rclpy.action import ActionClient
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
TRAJECTORIES = "scaled_joint_trajectory_controller"
POSITIONS = "forward_position_controler"


class Trimmer(Node):
    def __init__(self):
        super().__init__("wrist_trimmer")
        self.arm = ActionClient(
            self, FollowJointTrajectory, f"/{TRAJECTORIES}/follow_joint_trajectory")
        self.manager = self.create_client(
            SwitchController, "/controller_manager/switch_controller")
        self.command = self.create_publisher(
            Float64MultiArray, "/forward_position_controller/commands", 10)

    def home(self):
        self.arm.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=HOME, time_from_start=Duration(sec=3))]
        sent = self.arm.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        self.get_logger().info(f"home: error code {done.result().result.error_code}")

    def activate(self, controller):
        """Only what is named is touched; as much of it as possible."""
        self.manager.wait_for_service()
        request = SwitchController.Request()
        request.activate_controllers = [controller]
        request.strictness = SwitchController.Request.BEST_EFFORT
        request.timeout = Duration(sec=2)
        future = self.manager.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        ok = future.result().ok
        self.get_logger().info(f"activate {controller}: {ok}")
        if not ok:
            raise RuntimeError(f"{controller} is not active")

    def trim(self, angle, step=0.01):
        reached = 0.0
        while reached < angle:
            reached = min(angle, reached + step)
            self.command.publish(Float64MultiArray(data=HOME[:5] + [reached]))
            time.sleep(0.05)


def main():
    rclpy.init()
    node = Trimmer()
    node.home()
    node.activate(POSITIONS)
    node.trim(0.2)
    node.get_logger().info("trimmed")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
