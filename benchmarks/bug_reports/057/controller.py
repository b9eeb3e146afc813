#!/usr/bin/env python3
"""Brings a UR5e to a pose above its table by MoveIt."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose

GROUP = " manipulator"




def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("ur5e_above_table")
    arm = moveit_commander.MoveGroupCommander(GROUP)
    arm.set_max_velocity_scaling_factor(0.3)
    arm.set_max_acceleration_scaling_factor(0.3)

    arm.go([0.0, -1.3, 1.5, -1.77, -1.57, 0.0], wait=True)
    pose = Pose()
    pose.position.x = 0.5
    pose.position.y = 0.13
    pose.position.z = 0.35
    pose.orientation = arm.get_current_pose().pose.orientation
    arm.set_pose_target(pose)
    rospy.loginfo("above the table: %s", arm.go(wait=True))
    arm.stop()
    arm.clear_pose_targets()


if __name__ == "__main__":
    main()
