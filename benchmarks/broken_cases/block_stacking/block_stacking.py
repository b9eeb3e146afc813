"""Bring a block from a pad to a tray with a Panda (ROS 1, moveit_commander)."""

import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose

PAD = (0.45, 0.15)
TRAY = (0.45, -0.15)
OVER, AT = 0.40, 0.1934  # of panda_link8


def pose_at(place, height):
    pose = Pose()
    pose.position.x = place[0]
    pose.position.y = place[1]
    pose.position.z = height
    pose.orientation.x = 0.9238795
    pose.orientation.y = -0.3826834
    return pose


class Stacking:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.hand = moveit_commander.MoveGroupCommander("hand")

    def fly(self, place, height):
        self.arm.set_pose_target(pose_at(place, height))
        if not self.arm.go(wait=True):
            raise RuntimeError("the arm did not get there")

    def open(self):
        self.hand.set_named_target("open")
        self.hand.go(wait=True)

    def close(self):
        self.hand.set_named_target("close")
        self.hand.go(wait=True)

    def take(self):
        self.open()
        self.fly(PAD, OVER)
        self.fly(PAD, AT)
        self.close()
        self.fly(PAD, OVER)

    def put(self):
        self.fly(TRAY, OVER)
        self.fly(TRAY, AT + 0.002)
        self.open()
        self.fly(TRAY, OVER)

    def park(self):
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("block_stacking")
    stacking = Stacking()
    stacking.park()
    stacking.take()
    stacking.put()
    stacking.park()


if __name__ == "__main__":
    main()
