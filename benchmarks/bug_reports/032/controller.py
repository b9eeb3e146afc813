#!/usr/bin/env python3
"""Moves a Panda to each target that another node sends (two of them)."""
import sys

import moveit_commander
import rospy
from std_msgs.msg import Float64


class Mover:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_max_acceleration_scaling_factor(0.4)
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)
        self.count = 0
        rospy.Subscriber("/cell/turn", Float64, self.on_target, queue_size=5)

    def on_target(self, message):
        self.count += 1
        joints = self.arm.get_current_joint_values()
        joints[0] = message.data
        done = self.arm.go(joints, wait=True)
        self.arm.stop()
        rospy.loginfo("target %d: %s", self.count, done)
        if self.count == 2:
            rospy.signal_shutdown("all targets served")


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_mover")
    Mover()
    rospy.spin()


if __name__ == "__main__":
    main()
