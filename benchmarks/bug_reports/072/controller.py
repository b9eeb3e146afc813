#!/usr/bin/env python3
"""Turns a Panda to the left by one latched trajectory on its controller's command topic."""
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
LEFT = [0.6, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


def main():
    rospy.init_node("turn_left")
    publisher = rospy.Publisher(
        "/position_joint_trajectory_controller/command", JointTrajectory,
        queue_size=1, latch=True)
    message = JointTrajectory()
    message.joint_names = JOINTS
    message.points = [JointTrajectoryPoint(
        positions=LEFT, time_from_start=rospy.Duration(4.0))]
    publisher.publish(message)
    rospy.sleep(7.0)
    rospy.loginfo("done")


if __name__ == "__main__":
    main()
