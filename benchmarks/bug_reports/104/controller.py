#!/usr/bin/env python3
"""Press a button 10 cm below the tool with a Panda; poses are given in the shoulder's frame."""
import sys

import moveit_commander
import rospy

DOWN = 0.10


class Presser:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.3)
        self.arm.set_pose_reference_frame("panda_link1")

    def height(self):
        return self.arm.get_current_pose().pose.position.z

    def move_by(self, dz):
        pose = self.arm.get_current_pose().pose
        pose.position.z += dz
        self.arm.set_pose_target(pose)
        done = self.arm.go(wait=True)
        self.arm.stop()
        self.arm.clear_pose_targets()
        return done

    def press(self):
        before = self.height()
        done = self.move_by(-DOWN)
        rospy.loginfo("moved %s, by %.3f m", done, self.height() - before)
        return done


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("press_button")
    presser = Presser()
    presser.arm.set_named_target("ready")
    presser.arm.go(wait=True)
    rospy.loginfo("reference frame %s", presser.arm.get_pose_reference_frame())
    if presser.press():
        rospy.sleep(0.5)
    presser.arm.set_named_target("ready")
    presser.arm.go(wait=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
