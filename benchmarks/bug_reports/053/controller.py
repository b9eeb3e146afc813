#!/usr/bin/env python3
"""Lowers the tool of a UR5e slowly by 15 cm along a straight line."""
import sys
from copy import deepcopy

import moveit_commander
import rospy

SLOW = 0.05
ABOVE = [0.0, -1.3, 1.5, -1.77, -1.57, 0.0]


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("ur5e_lower")
    arm = moveit_commander.MoveGroupCommander("manipulator")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.go(ABOVE, wait=True)
    arm.stop()

    target = deepcopy(arm.get_current_pose().pose)
    target.position.z -= 0.15
    plan, fraction = arm.compute_cartesian_path([target], 0.005)
    if fraction < 1.0:
        raise RuntimeError("only %.2f of the way" % fraction)
    plan = arm.retime_trajectory(arm.get_current_state(), plan, SLOW, SLOW)
    seconds = plan.joint_trajectory.points[-1].time_from_start.to_sec()
    rospy.loginfo("the way down takes %.2f s", seconds)
    if seconds < 2.5:
        raise RuntimeError("too fast")
    if not arm.execute(plan, wait=True):
        raise RuntimeError("not executed")
    rospy.loginfo("lowered")


if __name__ == "__main__":
    main()
