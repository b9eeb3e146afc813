#!/usr/bin/env python3
"""Turns the base of a Panda by a quarter and checks it."""
import sys

import moveit_commander
import rospy


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_quarter")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)
    arm.set_named_target("ready")
    arm.go(wait=True)
    arm.stop()

    joints = arm.get_current_joint_values()
    joints[0] = 1.57
    arm.set_joint_value_target(joints)
    rospy.sleep(3.0)

    now = arm.get_current_joint_values()
    if abs(now[0] - 1.57) > 0.05:
        raise RuntimeError("joint 1 is at %.2f" % now[0])
    rospy.loginfo("turned")


if __name__ == "__main__":
    main()
