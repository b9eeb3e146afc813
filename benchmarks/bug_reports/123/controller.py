#!/usr/bin/env python3
"""Show a badge to two readers with a Panda: the flange level, the badge upright.

Of each pose only the position and w of the orientation are written; the rest keeps what a
new message has.
"""
import math
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose

READERS = [
    ("door", (0.28, -0.2, 0.5)),
    ("gate", (0.4, 0.1, 0.4)),
]
LINK = "panda_link8"
NEAR = 0.01         # [m]
UPRIGHT = 0.02      # [rad]


def level_pose(xyz):
    pose = Pose()
    pose.orientation.w = 1.0
    pose.position.x, pose.position.y, pose.position.z = xyz
    return pose


def distance(a, b):
    return math.sqrt((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2)


def turned(a, b):
    """The angle between two orientations."""
    dot = abs(a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w)
    return 2.0 * math.acos(min(1.0, dot))


class Badge:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.3)
        self.arm.set_max_acceleration_scaling_factor(0.3)

    def ready(self):
        self.arm.set_named_target("ready")
        if not self.arm.go(wait=True):
            raise RuntimeError("the ready pose was not reached")
        self.arm.stop()

    def show(self, name, xyz):
        target = level_pose(xyz)
        q = target.orientation
        rospy.loginfo("%s: orientation %.1f %.1f %.1f %.1f", name, q.x, q.y, q.z, q.w)
        self.arm.set_pose_target(target, LINK)
        reached = self.arm.go(wait=True)
        self.arm.stop()
        self.arm.clear_pose_targets()
        if not reached:
            raise RuntimeError("the %s was not reached" % name)
        now = self.arm.get_current_pose(LINK).pose
        off = distance(now.position, target.position)
        tilt = turned(now.orientation, target.orientation)
        rospy.loginfo("%s: %.1f mm and %.4f rad off", name, 1000.0 * off, tilt)
        if off > NEAR or tilt > UPRIGHT:
            raise RuntimeError("the badge is not where the %s reads it" % name)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("show_badge")
    badge = Badge()
    badge.ready()
    for name, xyz in READERS:
        badge.show(name, xyz)
    badge.ready()
    rospy.loginfo("both readers have seen the badge")


if __name__ == "__main__":
    main()
