#!/usr/bin/env python3
"""Moves the hand of a Panda 12 cm to the left along the edge of a table."""
import sys
from copy import deepcopy

import moveit_commander
import rospy


class Edge:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.5)
        self.arm.set_max_acceleration_scaling_factor(0.5)

    def begin(self):
        self.arm.set_named_target("ready")
        return self.arm.go(wait=True)

    def line(self, length):
        target = deepcopy(self.arm.get_current_pose().pose)
        target.position.y += length
        return self.arm.compute_cartesian_path([target], 0.01)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_edge")
    edge = Edge()
    edge.begin()
    plan = edge.line(0.12)
    edge.arm.execute(plan, wait=True)
    rospy.loginfo("along the edge")


if __name__ == "__main__":
    main()
