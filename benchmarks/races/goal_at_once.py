"""Sends a goal soon after creating the action client, without waiting for the server.

Source: PR2/pr2_common issue 114, ros/actionlib issue 46.
"""

import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


class Mover(Node):
    def __init__(self):
        super().__init__("goal_at_once")
        self.client = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory"
        )

    def move(self, turn):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint(positions=[turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8])
        point.time_from_start.sec = 3
        goal.trajectory.points = [point]
        future = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, future, timeout_sec=2.0)
        handle = future.result()
        if handle is not None:
            rclpy.spin_until_future_complete(self, handle.get_result_async(), timeout_sec=10.0)


def main():
    rclpy.init()
    node = Mover()
    rclpy.spin_once(node, timeout_sec=0.15)
    for turn in (0.5, -0.5):
        node.move(turn)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
