#!/usr/bin/env python3
"""A UR5e asks the camera where the next tray stands, and turns to it; the camera may take its time."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
PATIENCE = 2.0      # [s] for an answer of the camera


class TrayTurner(Node):
    def __init__(self):
        super().__init__("tray_turner")
        self.camera = self.create_client(Trigger, "/camera/locate")
        self.arm = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.camera.wait_for_service()
        self.arm.wait_for_server()

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=3))]
        sent = self.arm.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().result.error_code

    def locate(self):
        """The bearing of the tray [rad], or None if the camera sees none."""
        future = self.camera.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self, future, timeout_sec=PATIENCE)
        answer = future.result()
        if not answer.success:
            self.get_logger().warn("no tray in sight")
            return None
        return float(answer.message)


def main():
    rclpy.init()
    node = TrayTurner()
    node.get_logger().info(f"home: error code {node.move(HOME)}")
    for number in (1, 2):
        bearing = node.locate()
        if bearing is None:
            continue
        code = node.move([bearing] + HOME[1:])
        node.get_logger().info(f"tray {number} at {bearing:.2f} rad: error code {code}")
    node.get_logger().info("all trays visited")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
