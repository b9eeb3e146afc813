#!/usr/bin/env python3
"""Raises the hand of a Panda by 10 cm from where tf says it is."""
import sys

import moveit_commander
import rospy
import tf
from geometry_msgs.msg import Pose


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_raise")
    listener = tf.TransformListener()
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)

    listener.waitForTransform("panda_link0", "panda_link8", rospy.Time(0), rospy.Duration(5.0))
    position, orientation = listener.lookupTransform(
        "panda_link0", "panda_link8", rospy.Time.now())
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = position
    (pose.orientation.x, pose.orientation.y,
     pose.orientation.z, pose.orientation.w) = orientation
    pose.position.z += 0.1
    arm.set_pose_target(pose)
    if arm.go(wait=True):
        rospy.loginfo("raised")


if __name__ == "__main__":
    main()
