#!/usr/bin/env python3
"""Lowers the hand of a Panda by 10 cm along a straight line (Noetic, MoveIt 1.1.16)."""
import copy
import sys

import moveit_commander
import rospy


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_down")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)
    arm.stop()

    waypoints = []
    pose = arm.get_current_pose().pose
    for _ in range(2):
        pose.position.z -= 0.05
        waypoints.append(copy.deepcopy(pose))

    (plan, fraction) = arm.compute_cartesian_path(
        waypoints,  # to follow
        0.01,       # eef_step
        0.0)        # jump_threshold
    rospy.loginfo("%.0f %% of the path", 100 * fraction)
    arm.execute(plan, wait=True)
    rospy.loginfo("down")
    moveit_commander.roscpp_shutdown()


if __name__ == "__main__":
    main()
