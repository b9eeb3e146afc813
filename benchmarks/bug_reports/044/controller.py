#!/usr/bin/env python3
"""Turns a Panda to the left; a wall between is told to MoveIt first."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped

START = [0.0, 0.2, 0.0, -1.9, 0.0, 2.1, 0.785]
LEFT = [1.2, 0.2, 0.0, -1.9, 0.0, 2.1, 0.785]


def add_wall():
    scene = moveit_commander.PlanningSceneInterface(synchronous=False)
    wall = PoseStamped()
    wall.header.frame_id = "panda_link0"
    wall.pose.position.x = 0.42
    wall.pose.position.y = 0.27
    wall.pose.position.z = 0.25
    wall.pose.orientation.w = 1.0
    scene.add_box("wall", wall, (0.5, 0.03, 0.5))
    return scene


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_behind_the_wall")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.3)
    arm.set_max_acceleration_scaling_factor(0.3)
    arm.set_planning_time(10.0)
    arm.go(START, wait=True)
    arm.stop()

    scene = add_wall()
    rospy.sleep(2.0)
    rospy.loginfo("known: %s", scene.get_known_object_names())
    rospy.loginfo("turned: %s", arm.go(LEFT, wait=True))
    arm.stop()


if __name__ == "__main__":
    main()
