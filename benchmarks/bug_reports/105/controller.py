#!/usr/bin/env python3
"""Trace a square of 8 cm with a Panda along straight lines (compute_cartesian_path)."""
import copy
import sys

import moveit_commander
import rospy

SIDE = 0.08
STEP = 0.01


def corners(start):
    """The corners after the start, which the path has anyway."""
    waypoints = []
    pose = copy.deepcopy(start)
    for axis, sign in (("x", 1), ("y", 1), ("x", -1), ("y", -1)):
        setattr(pose.position, axis, getattr(pose.position, axis) + sign * SIDE)
        waypoints.append(copy.deepcopy(pose))
    return waypoints


def strictly_later(trajectory):
    times = [p.time_from_start.to_sec() for p in trajectory.joint_trajectory.points]
    return all(a < b for a, b in zip(times, times[1:]))


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("trace_square")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_named_target("ready")
    arm.go(wait=True)
    start = arm.get_current_pose().pose

    path, fraction = arm.compute_cartesian_path(corners(start), STEP)
    rospy.loginfo("fraction %.2f, %d points", fraction, len(path.joint_trajectory.points))
    if fraction < 1.0:
        return 1
    path = arm.retime_trajectory(arm.get_current_state(), path, 0.2, 0.2)
    rospy.loginfo("times strictly increase: %s", strictly_later(path))
    if not arm.execute(path, wait=True):
        return 1
    end = arm.get_current_pose().pose
    off = max(abs(end.position.x - start.position.x), abs(end.position.y - start.position.y),
              abs(end.position.z - start.position.z))
    rospy.loginfo("ends %.4f m from where it began", off)
    return 0


if __name__ == "__main__":
    sys.exit(main())
