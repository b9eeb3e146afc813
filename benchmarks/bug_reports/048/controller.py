#!/usr/bin/env python3
"""Pushes a part forward to the wall with a Panda, along a straight line."""
import sys
from copy import deepcopy

import moveit_commander
import rospy

WALL = 0.95


class Pusher:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.3)
        self.arm.set_max_acceleration_scaling_factor(0.3)

    def begin(self):
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)
        self.arm.stop()

    def push(self):
        pose = deepcopy(self.arm.get_current_pose().pose)
        waypoints = []
        while pose.position.x < WALL:
            pose.position.x = min(WALL, pose.position.x + 0.1)
            waypoints.append(deepcopy(pose))
        plan, _ = self.arm.compute_cartesian_path(waypoints, 0.01)
        plan = self.arm.retime_trajectory(self.arm.get_current_state(), plan, 0.2, 0.2)
        self.arm.execute(plan, wait=True)
        self.arm.stop()


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_push")
    pusher = Pusher()
    pusher.begin()
    pusher.push()
    rospy.loginfo("at the wall")


if __name__ == "__main__":
    main()
