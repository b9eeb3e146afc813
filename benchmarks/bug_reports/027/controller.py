#!/usr/bin/env python3
"""Streams a slow swing of the base to the trajectory controller of a Panda."""
import math

import rospy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
RATE = 50
SECONDS = 4.0


def here():
    while True:
        state = rospy.wait_for_message("/joint_states", JointState)
        positions = dict(zip(state.name, state.position))
        if all(name in positions for name in JOINTS):
            return [positions[name] for name in JOINTS]


def main():
    rospy.init_node("panda_swing")
    publisher = rospy.Publisher(
        "/position_joint_trajectory_controller/command", JointTrajectory, queue_size=1)
    start = here()
    while publisher.get_num_connections() == 0:
        rospy.sleep(0.1)
    rate = rospy.Rate(RATE)
    for number in range(int(RATE * SECONDS)):
        message = JointTrajectory()
        message.header.stamp = rospy.Time.now()
        message.joint_names = JOINTS
        positions = list(start)
        positions[0] += 0.2 * (1.0 - math.cos(math.pi * number / (RATE * SECONDS)))
        message.points.append(JointTrajectoryPoint(
            positions=positions, time_from_start=rospy.Duration(0)))
        publisher.publish(message)
        rate.sleep()
    rospy.loginfo("streamed")


if __name__ == "__main__":
    main()
