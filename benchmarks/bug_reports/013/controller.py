#!/usr/bin/env python3
"""Carries a box that a person has put into the hand of a Panda to the left side."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_carry")
    scene = moveit_commander.PlanningSceneInterface()
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)
    arm.stop()

    # The box reaches from the hand to 5 cm below the finger tips.
    pose = PoseStamped()
    pose.header.frame_id = "panda_hand"
    pose.pose.position.z = 0.11
    pose.pose.orientation.w = 1.0
    scene.attach_box("panda_hand", "box", pose, size=(0.1, 0.1, 0.1))
    rospy.sleep(1.0)
    rospy.loginfo("attached: %s", list(scene.get_attached_objects(["box"])))

    target = arm.get_current_joint_values()
    target[0] = 0.8
    if arm.go(target, wait=True):
        rospy.loginfo("carried")
    else:
        rospy.logerr("not carried")
    arm.stop()


if __name__ == "__main__":
    main()
