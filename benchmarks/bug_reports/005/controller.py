#!/usr/bin/env python3
"""Offers a service that brings a UR5e to the next pose of its list."""
import rclpy
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
POSES = [
    [0.0, -1.2, 1.6, -1.97, -1.57, 0.0],
    [0.8, -1.2, 1.6, -1.97, -1.57, 0.0],
]


class PoseServer(Node):
    def __init__(self):
        super().__init__("ur5e_pose_server")
        group = ReentrantCallbackGroup()
        self.arm = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory",
            callback_group=group)
        self.arm.wait_for_server()
        self.count = 0
        self.create_service(Trigger, "/cell/next_pose", self.next_pose, callback_group=group)
        self.get_logger().info("ready")

    def next_pose(self, request, response):
        self.count += 1
        self.get_logger().info(f"request {self.count}")
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint()
        point.positions = POSES[(self.count - 1) % len(POSES)]
        point.time_from_start = Duration(sec=4)
        goal.trajectory.points.append(point)

        sent = self.arm.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)

        response.success = done.result().status == GoalStatus.STATUS_SUCCEEDED
        response.message = f"pose {self.count}"
        self.get_logger().info(f"pose {self.count} reached")
        return response


def main():
    rclpy.init()
    node = PoseServer()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)
    try:
        executor.spin()
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
