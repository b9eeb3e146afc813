"""Publishes a command soon after creating the publisher: often nobody is connected yet.

Source: ros/ros_comm issue 176.
"""

import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


def move(publisher, first):
    command = JointTrajectory(joint_names=JOINTS)
    positions = [first, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8]
    command.points = [
        JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(3.0))
    ]
    publisher.publish(command)


def main():
    rospy.init_node("publish_at_once")
    publisher = rospy.Publisher(
        "/position_joint_trajectory_controller/command", JointTrajectory, queue_size=1
    )
    rospy.sleep(0.25)
    move(publisher, 0.4)
    rospy.sleep(4.0)
    move(publisher, -0.4)
    rospy.sleep(4.0)


if __name__ == "__main__":
    main()
