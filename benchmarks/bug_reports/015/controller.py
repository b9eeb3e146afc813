#!/usr/bin/env python3
"""Lowers the hand of a Panda by 10 cm; poses are those of panda_hand, not of panda_link8."""
import sys
from copy import deepcopy

import moveit_commander
import rospy


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_lower_hand")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)

    arm.set_end_effector_link("panda_hand")
    before = arm.get_current_pose().pose
    target = deepcopy(before)
    target.position.z -= 0.1
    plan, fraction = arm.compute_cartesian_path([target], 0.01)
    if fraction < 1.0:
        raise RuntimeError("only %.2f of the line" % fraction)
    plan = arm.retime_trajectory(arm.get_current_state(), plan, 0.3, 0.3)
    if not arm.execute(plan, wait=True):
        raise RuntimeError("not executed")
    rospy.sleep(0.5)
    after = arm.get_current_pose().pose
    if abs(before.position.z - after.position.z - 0.1) > 0.005:
        raise RuntimeError("the hand is not 10 cm lower")
    rospy.loginfo("lowered")


if __name__ == "__main__":
    main()
