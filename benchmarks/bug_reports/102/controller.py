#!/usr/bin/env python3
"""Swing a Panda from one side to the other, around a post that stands in between."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped

LEFT = [0.9, 0.4, 0.0, -1.7, 0.0, 2.1, 0.785]
RIGHT = [-0.9, 0.4, 0.0, -1.7, 0.0, 2.1, 0.785]


def post():
    pose = PoseStamped()
    pose.header.frame_id = "panda_link0"
    pose.pose.position.x = 0.55
    pose.pose.position.z = 0.35
    pose.pose.orientation.w = 1.0
    return pose


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("beside_the_post")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_planning_time(10.0)
    arm.set_max_velocity_scaling_factor(0.3)
    arm.go(LEFT, wait=True)

    scene = moveit_commander.PlanningSceneInterface(synchronous=False)
    scene.add_box("post", post(), size=(0.08, 0.08, 0.7))
    rospy.sleep(2.0)
    rospy.loginfo("known objects: %s", scene.get_known_object_names())

    rospy.loginfo("to the right: %s", arm.go(RIGHT, wait=True))
    rospy.loginfo("to the left: %s", arm.go(LEFT, wait=True))
    scene.remove_world_object("post")
    rospy.sleep(1.0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
