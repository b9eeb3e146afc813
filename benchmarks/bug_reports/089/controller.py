#!/usr/bin/env python3
"""Tells MoveIt about a box on the table and moves a Panda around it."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped


def add_box(scene):
    pose = PoseStamped()
    pose.header.frame_id = "tabel_top"
    pose.pose.position.x = 0.1
    pose.pose.position.z = 0.1
    pose.pose.orientation.w = 1.0
    scene.add_box("box", pose, (0.1, 0.1, 0.2))
    for _ in range(20):
        if "box" in scene.get_known_object_names():
            return
        rospy.sleep(0.1)
    raise RuntimeError("the box is not in the scene")


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_around_box")
    scene = moveit_commander.PlanningSceneInterface()
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)
    add_box(scene)
    target = arm.get_current_joint_values()
    target[0] = 0.6
    rospy.loginfo("moved: %s", arm.go(target, wait=True))


if __name__ == "__main__":
    main()
