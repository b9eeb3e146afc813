#!/usr/bin/env python3
"""Swing a Panda between a named state and a joint target, planning and executing apart."""
import sys

import moveit_commander
import rospy

ROUNDS = 3


class Swing:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.3)
        self.arm.set_max_acceleration_scaling_factor(0.2)

    def plan_and_execute(self):
        success, trajectory, seconds, code = self.arm.plan()
        if not success:
            rospy.logerr("no plan (%d)", code.val)
            return False
        rospy.loginfo("%d points", len(trajectory.joint_trajectory.points))
        return self.arm.execute(trajectory, wait=True)

    def to_ready(self):
        self.arm.set_named_target("ready")
        return self.plan_and_execute()

    def lean(self, angle):
        self.arm.set_joint_value_target({"panda_joint2": angle})
        return self.plan_and_execute()


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("alternate")
    swing = Swing()
    for number in range(ROUNDS):
        if not swing.lean(0.1 * (number + 1)):
            return 1
        if not swing.to_ready():
            return 1
        rospy.loginfo("round %d of %d", number + 1, ROUNDS)
    joints = swing.arm.get_current_joint_values()
    rospy.loginfo("joint 2 ends at %.3f", joints[1])
    return 0


if __name__ == "__main__":
    sys.exit(main())
