#!/usr/bin/env python
"""Palletise four boxes from the infeed lane (ROS 1, MoveIt)."""
import os
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose
from std_msgs.msg import Int32
from std_srvs.srv import Trigger

from layout import Layout

HERE = os.path.dirname(os.path.abspath(__file__))


class Palletiser(object):
    def __init__(self, layout):
        self.layout = layout
        self.speed = layout.cfg["speed"]
        self.arm = moveit_commander.MoveGroupCommander("panda_manipulator")
        self.hand = moveit_commander.MoveGroupCommander("hand")
        self.hand.set_max_velocity_scaling_factor(1.0)
        self.hand.set_max_acceleration_scaling_factor(1.0)
        self.placed = 0
        self.count_pub = rospy.Publisher("/pallet/count", Int32, queue_size=4, latch=True)
        rospy.wait_for_service("/pallet/new_sheet")
        self.new_sheet = rospy.ServiceProxy("/pallet/new_sheet", Trigger)

    # -- motion ---------------------------------------------------------
    def _pose(self, slot, dz=0.0):
        pose = Pose()
        pose.position.x = slot.x
        pose.position.y = slot.y
        pose.position.z = slot.z + dz
        pose.orientation.x = 1.0
        return pose

    def travel(self, slot, speed):
        self.arm.set_max_velocity_scaling_factor(speed)
        self.arm.set_max_acceleration_scaling_factor(speed)
        self.arm.set_pose_target(self._pose(slot, self.layout.clearance))
        ok = self.arm.go(wait=True)
        self.arm.stop()
        self.arm.clear_pose_targets()
        if not ok:
            raise RuntimeError("cannot travel to %s" % (slot,))

    def straight(self, slot, dz=0.0):
        plan, fraction = self.arm.compute_cartesian_path([self._pose(slot, dz)], 0.01)
        if fraction < 0.999:
            raise RuntimeError("straight path ends after %.0f %%" % (100 * fraction))
        s = self.speed["straight"]
        plan = self.arm.retime_trajectory(self.arm.get_current_state(), plan, s, s)
        self.arm.execute(plan, wait=True)

    def fingers(self, state):
        self.hand.set_named_target(state)
        self.hand.go(wait=True)

    # -- task -----------------------------------------------------------
    def take(self, slot):
        self.fingers("open")
        self.travel(slot, self.speed["free"])
        self.straight(slot)
        self.fingers("close")
        self.straight(slot, self.layout.clearance)

    def put(self, slot):
        self.travel(slot, self.speed["carrying"])
        self.straight(slot)
        self.fingers("open")
        self.straight(slot, self.layout.clearance)
        self.placed += 1
        self.count_pub.publish(Int32(data=self.placed))

    def run(self):
        per_layer = self.layout.cfg["pallet"]["columns"]
        for source, target in zip(self.layout.infeed(), self.layout.pallet()):
            if self.placed and self.placed % per_layer == 0:
                self.new_sheet()
            self.take(source)
            self.put(target)
            rospy.loginfo("box %d at %.3f %.3f %.3f", self.placed, *target)
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)


if __name__ == "__main__":
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("palletise")
    Palletiser(Layout(os.path.join(HERE, "pallet.yaml"))).run()
    moveit_commander.roscpp_shutdown()
