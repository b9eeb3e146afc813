#!/usr/bin/env python3
"""Shows a UR5e's tool to the camera from two sides."""
import rospy
from arm import Arm

SIDES = [[0.3, -1.4, 1.6, -1.77, -1.57, 0.0], [-0.3, -1.4, 1.6, -1.77, -1.57, 0.0]]


def main():
    arm = Arm()
    rospy.init_node("show_tool")
    for number, pose in enumerate(SIDES, 1):
        arm.go(pose, 5.0)
        rospy.loginfo("side %d", number)
        rospy.sleep(1.0)


if __name__ == "__main__":
    main()
