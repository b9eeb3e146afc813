#!/usr/bin/env python3
"""Inspect the wells of a plate with a Panda, and probe each of them with the hand.

The camera is bolted to the flange, so the pose for looking is given for panda_link8;
the probe is clamped into the hand, so the pose for probing is given for panda_hand.
"""
import copy
import sys

import moveit_commander
import rospy

FLANGE = "panda_link8"
HAND = "panda_hand"
WELLS = [("a1", 0.00), ("a2", 0.06)]      # name, offset along y [m]
LOOK_HEIGHT = 0.06
PROBE_DEPTH = 0.10


class Plate:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.3)
        self.arm.set_max_acceleration_scaling_factor(0.3)
        self.arm.set_planning_time(5.0)
        self.above = None
        self.results = []

    def begin(self):
        self.arm.set_named_target("ready")
        if not self.arm.go(wait=True):
            raise RuntimeError("the ready pose was not reached")
        self.arm.stop()
        self.above = {
            FLANGE: self.arm.get_current_pose(FLANGE),
            HAND: self.arm.get_current_pose(HAND),
        }

    def shifted(self, link, dy, dz):
        """The pose that the link had in the ready pose, moved by dy and dz."""
        target = copy.deepcopy(self.above[link])
        target.pose.position.y += dy
        target.pose.position.z += dz
        return target

    def look(self, name, dy):
        self.arm.set_start_state_to_current_state()
        self.arm.set_pose_target(self.shifted(FLANGE, dy, LOOK_HEIGHT), FLANGE)
        seen = self.arm.go(wait=True)
        self.arm.stop()
        rospy.loginfo("look at %s: %s", name, seen)
        if not seen:
            raise RuntimeError("no view of well %s" % name)

    def probe(self, name, dy):
        self.arm.set_start_state_to_current_state()
        self.arm.set_pose_target(self.shifted(HAND, dy, -PROBE_DEPTH), HAND)
        touched = self.arm.go(wait=True)
        self.arm.stop()
        rospy.loginfo("probe %s: %s", name, touched)
        if not touched:
            raise RuntimeError("well %s could not be probed" % name)
        self.results.append(name)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("plate_probe")
    plate = Plate()
    plate.begin()
    for name, dy in WELLS:
        plate.look(name, dy)
        plate.probe(name, dy)
    rospy.loginfo("probed: %s", ", ".join(plate.results))
    moveit_commander.roscpp_shutdown()


if __name__ == "__main__":
    main()
