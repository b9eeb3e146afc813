#!/usr/bin/env python3
"""Stretches a Panda upwards from its ready pose."""
import sys

import moveit_commander
import rospy

STRETCHED = {"panda_joint2": -0.1, "panda_joint4": 0.3, "panda_joint6": 1.9}


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_stretch")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.3)
    arm.set_max_acceleration_scaling_factor(0.3)

    arm.set_named_target("ready")
    if not arm.go(wait=True):
        raise RuntimeError("the ready pose was not reached")
    arm.stop()

    target = dict(zip(arm.get_active_joints(), arm.get_current_joint_values()))
    target.update(STRETCHED)
    arm.set_joint_value_target(target)
    if arm.go(wait=True):
        rospy.loginfo("stretched")
    arm.stop()


if __name__ == "__main__":
    main()
