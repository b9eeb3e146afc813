#!/usr/bin/env python3
"""Turns the last joint of a Sawyer at 0.3 rad/s for two seconds."""
import rospy
from intera_core_msgs.msg import JointCommand
from sensor_msgs.msg import JointState

JOINT = "right_j6"
SPEED = 0.3
SECONDS = 2.0


def angle():
    while True:
        state = rospy.wait_for_message("/robot/joint_states", JointState)
        if JOINT in state.name:
            return state.position[state.name.index(JOINT)]


def main():
    rospy.init_node("sawyer_turn")
    publisher = rospy.Publisher(
        "/robot/limb/right/joint_command", JointCommand, queue_size=1)
    while publisher.get_num_connections() == 0:
        rospy.sleep(0.1)
    before = angle()
    command = JointCommand()
    command.mode = JointCommand.VELOCITY_MODE
    command.names = [JOINT]
    command.velocity = [SPEED]
    command.header.stamp = rospy.Time.now()
    publisher.publish(command)
    rospy.sleep(SECONDS)
    command.velocity = [0.0]
    command.header.stamp = rospy.Time.now()
    publisher.publish(command)
    rospy.sleep(0.5)
    rospy.loginfo("turned by %.2f", angle() - before)


if __name__ == "__main__":
    main()
