#!/usr/bin/env python3
"""Bring a tray to three stations, one after the other, with a UR5e (actionlib, ROS 1)."""
import sys

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
STATIONS = [
    ("oven", [-0.8, -1.5, 1.5, -1.57, -1.57, 0.0]),
    ("bath", [0.0, -1.2, 1.2, -1.57, -1.57, 0.0]),
    ("rack", [0.8, -1.5, 1.5, -1.57, -1.57, 0.0]),
]
SECONDS = 4.0


def goal_to(positions):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    point = JointTrajectoryPoint()
    point.positions = positions
    point.velocities = [0.0] * len(JOINTS)
    point.time_from_start = rospy.Duration(SECONDS)
    goal.trajectory.points.append(point)
    return goal


class Tour:
    def __init__(self):
        self.ended = []
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.client.wait_for_server()

    def run(self):
        began = rospy.get_time()
        for name, positions in STATIONS:
            rospy.loginfo("to the %s", name)
            self.client.send_goal(goal_to(positions),
                                  done_cb=lambda state, _, n=name: self.ended.append((n, state)))
        self.client.wait_for_result()
        rospy.loginfo("all stations served in %.1f s", rospy.get_time() - began)
        rospy.sleep(1.0)
        rospy.loginfo("ended: %s", self.ended)


def main():
    rospy.init_node("three_stations")
    Tour().run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
