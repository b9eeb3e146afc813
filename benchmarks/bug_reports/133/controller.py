#!/usr/bin/env python3
"""A UR5e plays poses that a web page sent as JSON, where a whole number has no point.

The numbers go into the messages through arrays of doubles, which take them as they come.
"""
import array
import json

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

PAGE = """
[{"name": "rest", "seconds": 3, "joints": [0, -1, 1, -2, -1, 0]},
 {"name": "show", "seconds": 2, "joints": [1, -1, 1, -1, -1, 0]},
 {"name": "back", "seconds": 2, "joints": [0, -1, 1, -2, -1, 0]}]
"""
JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


def point_of(pose):
    """One pose of the page as a point of a trajectory."""
    point = JointTrajectoryPoint()
    point.positions = array.array("d", pose["joints"])
    point.velocities.extend([0] * len(JOINTS))
    point.time_from_start = Duration(sec=pose["seconds"])
    return point


class Player(Node):
    def __init__(self):
        super().__init__("pose_player")
        self.client = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.client.wait_for_server()

    def play(self, pose):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(point_of(pose))
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        if not sent.result().accepted:
            raise RuntimeError(f"{pose['name']} was rejected")
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().result.error_code


def main():
    rclpy.init()
    node = Player()
    poses = json.loads(PAGE)
    for pose in poses:
        point = point_of(pose)
        kind = type(point.positions).__name__
        first = np.asarray(point.positions)[0]
        code = node.play(pose)
        node.get_logger().info(
            f"{pose['name']}: {kind}, first {float(first):.1f}, error code {code}")
    node.get_logger().info(f"played {len(poses)} poses")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
