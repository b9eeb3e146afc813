#!/usr/bin/env python3
"""Load three vials into the centrifuge, balanced (Panda, ROS 1)."""
import os
import sys

import moveit_commander
import rospy
import yaml
from std_msgs.msg import String
from std_srvs.srv import Trigger

from bench import Bench
from hand import Hand


class Loader(object):
    def __init__(self, bench):
        self.bench = bench
        self.arm = moveit_commander.MoveGroupCommander("panda_manipulator")
        self.hand = Hand()
        self.loaded = rospy.Publisher("/lims/loaded", String, queue_size=10)
        self.unlock = rospy.ServiceProxy("/centrifuge/unlock", Trigger)
        self.close_lid = rospy.ServiceProxy("/centrifuge/close_lid", Trigger)

    def speed(self, which):
        factor = self.bench.speed[which]
        self.arm.set_max_velocity_scaling_factor(factor)
        self.arm.set_max_acceleration_scaling_factor(factor)

    def over(self, xy):
        """Travel to a place at the clear height."""
        self.speed("travel")
        self.arm.set_pose_target(self.bench.pose(xy, self.bench.clear))
        ok = self.arm.go(wait=True)
        self.arm.stop()
        self.arm.clear_pose_targets()
        if not ok:
            raise RuntimeError("cannot get over %s" % (xy,))

    def straight(self, xy, height):
        """Straight up or down above a place."""
        factor = self.bench.speed["careful"]
        path, fraction = self.arm.compute_cartesian_path([self.bench.pose(xy, height)], 0.01)
        if fraction < 0.99:
            raise RuntimeError("straight path only %.2f" % fraction)
        path = self.arm.retime_trajectory(self.arm.get_current_state(), path, factor, factor)
        self.arm.execute(path, wait=True)

    def transfer(self, tray, slot):
        here, there = self.bench.tray(tray), self.bench.slot(slot)
        self.hand.open()
        self.over(here)
        self.straight(here, self.bench.grip)
        if not self.hand.grasp():
            rospy.logwarn("no vial at tray position %d", tray)
            self.straight(here, self.bench.clear)
            return False
        self.straight(here, self.bench.clear)
        self.over(there)
        self.straight(there, self.bench.seat)
        self.hand.open()
        self.straight(there, self.bench.clear)
        self.loaded.publish(String(data="%d:%d" % (tray, slot)))
        return True

    def run(self, load):
        if not self.unlock().success:
            raise RuntimeError("rotor is locked")
        done = [self.transfer(entry["tray"], entry["slot"]) for entry in load]
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)
        if all(done):
            self.close_lid()
        return all(done)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("load_centrifuge")
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "bench.yaml")) as f:
        config = yaml.safe_load(f)
    loader = Loader(Bench(config))
    ok = loader.run(config["load"])
    rospy.loginfo("rotor loaded: %s", ok)
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
