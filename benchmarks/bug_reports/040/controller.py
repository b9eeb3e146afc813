#!/usr/bin/env python3
"""Replays joint positions of a UR5e that were written into a CSV file."""
import csv
import os

import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


def rows():
    name = os.path.join(os.path.dirname(os.path.abspath(__file__)), "poses.csv")
    with open(name) as table:
        for row in csv.reader(table):
            yield row


def main():
    rospy.init_node("ur5e_replay")
    publisher = rospy.Publisher(
        "/scaled_pos_joint_traj_controller/command", JointTrajectory, queue_size=5)
    while publisher.get_num_connections() == 0 and not rospy.is_shutdown():
        rospy.sleep(0.1)

    message = JointTrajectory()
    message.joint_names = JOINTS
    seconds = 0.0
    for row in rows():
        seconds += 3.0
        point = JointTrajectoryPoint()
        point.positions = row
        point.time_from_start = rospy.Duration(seconds)
        message.points.append(point)
    rospy.loginfo("sending %d points", len(message.points))
    publisher.publish(message)
    rospy.sleep(seconds + 1.0)
    rospy.loginfo("all rows sent")


if __name__ == "__main__":
    main()
