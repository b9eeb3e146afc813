#!/usr/bin/env python3
"""Lowers the tool of a KUKA LBR iiwa by 5 cm (iiwa_stack)."""
import rospy
from iiwa_msgs.msg import CartesianPose


class Lower:
    def __init__(self):
        self.pose = None
        rospy.Subscriber("/iiwa/state/CartesianPose", CartesianPose, self.on_pose)
        self.command = rospy.Publisher(
            "/iiwa/command/CartesianPose", CartesianPose, queue_size=10)

    def on_pose(self, message):
        self.pose = message

    def run(self):
        rate = rospy.Rate(10)
        while self.pose is None and not rospy.is_shutdown():
            rate.sleep()
        target = self.pose
        target.poseStamped.pose.position.z -= 0.05
        for _ in range(50):
            target.poseStamped.header.stamp = rospy.Time.now()
            self.command.publish(target)
            rate.sleep()
        rospy.loginfo("lowered")


def main():
    rospy.init_node("iiwa_lower")
    Lower().run()


if __name__ == "__main__":
    main()
