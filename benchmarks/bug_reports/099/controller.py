#!/usr/bin/env python3
"""Probe 5 cm in front of the hand, in two postures, with a Panda (tf, MoveIt, ROS 1)."""
import sys

import moveit_commander
import rospy
import tf
from geometry_msgs.msg import PoseStamped

POSTURES = [
    [0.3, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
    [-0.3, -0.6, 0.0, -2.2, 0.0, 1.7, 0.785],
]


class Probe:
    def __init__(self):
        self.listener = tf.TransformListener()
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.3)

    def point_ahead(self, distance):
        """The pose of the flange, that much further along its own axis, in the base frame."""
        ahead = PoseStamped()
        ahead.header.frame_id = "panda_link8"
        ahead.header.stamp = rospy.Time.now()
        ahead.pose.position.z = distance
        ahead.pose.orientation.w = 1.0
        return self.listener.transformPose("panda_link0", ahead)

    def probe(self):
        target = self.point_ahead(0.05)
        self.arm.set_pose_target(target)
        reached = self.arm.go(wait=True)
        self.arm.clear_pose_targets()
        return reached


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("tf_probe")
    probe = Probe()
    rospy.sleep(1.013)
    for number, posture in enumerate(POSTURES, 1):
        probe.arm.go(posture, wait=True)
        rospy.loginfo("posture %d: probed %s", number, probe.probe())
    return 0


if __name__ == "__main__":
    sys.exit(main())
