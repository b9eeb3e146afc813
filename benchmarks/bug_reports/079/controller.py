#!/usr/bin/env python3
"""Remembers where a Panda stands, turns it, and brings it back."""
import sys

import moveit_commander
import rospy


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_there_and_back")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)
    arm.set_named_target("ready")
    arm.go(wait=True)
    arm.stop()

    before = arm.get_current_state()
    joints = arm.get_current_joint_values()
    joints[0] = 0.5
    arm.go(joints, wait=True)
    arm.stop()

    arm.set_joint_value_target(before)
    arm.go(wait=True)
    rospy.loginfo("back")


if __name__ == "__main__":
    main()
