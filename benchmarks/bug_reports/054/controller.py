#!/usr/bin/env python3
"""Turns a Panda to the right (Noetic; the program was written for Melodic)."""
import sys

import moveit_commander
import rospy


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_right")
    group = moveit_commander.MoveGroupCommander("panda_arm")
    group.set_max_velocity_scaling_factor(0.4)
    group.set_max_acceleration_scaling_factor(0.4)
    group.set_named_target("ready")
    group.go(wait=True)
    group.stop()

    joints = group.get_current_joint_values()
    joints[0] = -0.7
    group.set_joint_value_target(joints)
    plan = group.plan()
    rospy.sleep(1.0)
    group.execute(plan, wait=True)
    rospy.loginfo("turned")


if __name__ == "__main__":
    main()
