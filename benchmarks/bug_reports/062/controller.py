#!/usr/bin/env python3
"""Attaches a small box to the hand of a Panda and turns with it."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped

HAND = "panda_gripper"


class Turn:
    def __init__(self):
        self.robot = moveit_commander.RobotCommander()
        self.scene = moveit_commander.PlanningSceneInterface()
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_max_acceleration_scaling_factor(0.4)

    def ready(self):
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)
        self.arm.stop()

    def attach(self):
        pose = PoseStamped()
        pose.header.frame_id = "panda_hand"
        pose.pose.position.z = 0.13
        pose.pose.orientation.w = 1.0
        touch = self.robot.get_link_names(group=HAND)
        self.scene.attach_box("panda_hand", "part", pose, (0.04, 0.04, 0.04), touch)
        rospy.sleep(0.5)

    def turn(self):
        joints = self.arm.get_current_joint_values()
        joints[0] = 0.6
        return self.arm.go(joints, wait=True)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_turn")
    turn = Turn()
    turn.ready()
    turn.attach()
    rospy.loginfo("turned: %s", turn.turn())


if __name__ == "__main__":
    main()
