#!/usr/bin/env python3
"""Brings a KUKA LBR iiwa to a pose of its joints (iiwa_stack)."""
import rospy
from iiwa_msgs.msg import JointPosition

TARGET = {"a1": 0.3, "a2": 0.4, "a3": 0.0, "a4": -1.2, "a5": 0.0, "a6": 0.9, "a7": 0.0}


class Pose:
    def __init__(self):
        self.state = None
        rospy.Subscriber("/iiwa/state/JointPosition", JointPosition, self.on_state)
        self.command = rospy.Publisher(
            "/iiwa/command/JointPosition", JointPosition, queue_size=1)

    def on_state(self, message):
        self.state = message.position

    def distance(self):
        return max(abs(getattr(self.state, name) - value) for name, value in TARGET.items())

    def run(self):
        rate = rospy.Rate(10)
        while self.state is None or self.command.get_num_connections() == 0:
            rate.sleep()
        message = JointPosition()
        for name, value in TARGET.items():
            setattr(message.position, name, value)
        message.header.stamp = rospy.Time.now()
        self.command.publish(message)
        while self.distance() > 0.02 and not rospy.is_shutdown():
            rate.sleep()
        rospy.loginfo("there")


def main():
    rospy.init_node("iiwa_pose")
    Pose().run()


if __name__ == "__main__":
    main()
