#!/usr/bin/env python3
"""A UR5e goes home, tells from tf how high its tool is, and lowers the forearm if that is too high."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import TransformException
from tf2_ros.buffer import Buffer
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
LOWERED = [0.0, -1.2, 1.57, -1.94, -1.57, 0.0]
TOO_HIGH = 0.40     # [m]


class HeightKeeper(Node):
    def __init__(self):
        super().__init__("height_keeper")
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.tf_buffer = Buffer()
        self.height = None
        self.timer = self.create_timer(1.0, self.on_timer)

    def on_timer(self):
        try:
            lookup_transform = self.tf_buffer.lookup_transform("base_link", "tool0", Time())
        except TransformException as error:
            self.get_logger().info(f"Could not transform tool0 to base_link: {error}")
            return
        self.height = lookup_transform.transform.translation.z

    def wait_for_height(self):
        self.height = None
        while self.height is None:
            rclpy.spin_once(self)
        return self.height

    def move(self, positions):
        self.client.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=3))]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().result.error_code


def main():
    rclpy.init()
    node = HeightKeeper()
    node.get_logger().info(f"home: error code {node.move(HOME)}")
    height = node.wait_for_height()
    node.get_logger().info(f"the tool is {height:.3f} m high")
    if height > TOO_HIGH:
        node.get_logger().info(f"lowered: error code {node.move(LOWERED)}")
        node.get_logger().info(f"now {node.wait_for_height():.3f} m")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
