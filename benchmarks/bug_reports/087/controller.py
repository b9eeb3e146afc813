#!/usr/bin/env python3
"""Turns the base of a Kinova j2n6s300 by 2 rad at 0.5 rad/s (kinova_driver)."""
import math

import rospy
from kinova_msgs.msg import JointAngles, JointVelocity

PREFIX = "/j2n6s300_driver"
SPEED = 0.5
ANGLE = 2.0


def base():
    message = rospy.wait_for_message(PREFIX + "/out/joint_angles", JointAngles)
    return math.radians(message.joint1)


def main():
    rospy.init_node("j2n6s300_turn")
    publisher = rospy.Publisher(PREFIX + "/in/joint_velocity", JointVelocity, queue_size=1)
    while publisher.get_num_connections() == 0:
        rospy.sleep(0.1)
    before = base()
    message = JointVelocity()
    message.joint1 = SPEED
    rate = rospy.Rate(100)
    for _ in range(int(100 * ANGLE / SPEED)):
        publisher.publish(message)
        rate.sleep()
    message.joint1 = 0.0
    for _ in range(20):
        publisher.publish(message)
        rate.sleep()
    rospy.loginfo("turned by %.3f rad", base() - before)


if __name__ == "__main__":
    main()
