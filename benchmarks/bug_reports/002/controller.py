#!/usr/bin/env python3
"""Adds a table to the planning scene of a Panda and moves above it."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_table")
    scene = moveit_commander.PlanningSceneInterface()
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)

    table = PoseStamped()
    table.header.frame_id = "panda_link0"
    table.pose.position.x = 0.6
    table.pose.position.z = 0.08
    table.pose.orientation.w = 1.0
    scene.add_box("table", table, (0.5, 0.8, 0.16))
    rospy.loginfo("known: %s", scene.get_known_object_names())

    if not arm.go([0.5, -0.2, 0.0, -2.1, 0.0, 1.9, 0.785], wait=True):
        raise RuntimeError("no way above the table")
    arm.stop()
    rospy.loginfo("above the table")


if __name__ == "__main__":
    main()
