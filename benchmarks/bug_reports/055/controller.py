#!/usr/bin/env python3
"""Turns a Panda to the left by one trajectory on its controller's command topic."""
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
LEFT = [0.6, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


def trajectory(positions, seconds):
    message = JointTrajectory()
    message.joint_names = JOINTS
    point = JointTrajectoryPoint()
    point.positions = positions
    point.time_from_start = rospy.Duration(seconds)
    message.points = [point]
    return message


def main():
    rospy.init_node("turn_left")
    publisher = rospy.Publisher(
        "/position_joint_trajectory_controller/command", JointTrajectory, queue_size=1)
    publisher.publish(trajectory(LEFT, 4.0))
    rospy.loginfo("trajectory sent")
    rospy.sleep(6.0)
    rospy.loginfo("done")


if __name__ == "__main__":
    main()
