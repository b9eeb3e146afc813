#!/usr/bin/env python3
"""Wipes a window slowly with a Panda: 20 cm to the left along a straight line."""
import sys
from copy import deepcopy

import moveit_commander
import rospy

SLOW = 0.05
SHORTEST = 2.5


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_wipe")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)
    arm.set_named_target("ready")
    arm.go(wait=True)

    arm.set_max_velocity_scaling_factor(SLOW)
    arm.set_max_acceleration_scaling_factor(SLOW)
    target = deepcopy(arm.get_current_pose().pose)
    target.position.y += 0.2
    plan, fraction = arm.compute_cartesian_path([target], 0.005)
    if fraction < 1.0:
        raise RuntimeError("only %.2f of the wipe" % fraction)
    seconds = plan.joint_trajectory.points[-1].time_from_start.to_sec()
    rospy.loginfo("the wipe takes %.2f s", seconds)
    if seconds < SHORTEST:
        raise RuntimeError("too fast")
    arm.execute(plan, wait=True)
    rospy.loginfo("wiped")


if __name__ == "__main__":
    main()
