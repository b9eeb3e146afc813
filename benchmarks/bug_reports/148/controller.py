#!/usr/bin/env python3
"""Turn the waist of a ViperX 300 S at a steady speed past a scanner: 0.3 rad/s for three seconds.

Uses the driver (xs_sdk) directly: the joint group "arm" takes one command per joint.
"""
import rospy
from interbotix_xs_msgs.msg import JointGroupCommand
from interbotix_xs_msgs.srv import RobotInfo
from sensor_msgs.msg import JointState

ROBOT = "/vx300s"
SPEED = 0.3         # [rad/s]
SECONDS = 3.0
ALLOWED = 0.15      # [rad]


class Scanner:
    def __init__(self):
        self.positions = {}
        rospy.Subscriber(ROBOT + "/joint_states", JointState, self.on_state)
        self.command = rospy.Publisher(
            ROBOT + "/commands/joint_group", JointGroupCommand, queue_size=5)
        rospy.wait_for_service(ROBOT + "/get_robot_info")
        self.info = rospy.ServiceProxy(ROBOT + "/get_robot_info", RobotInfo)("group", "arm")
        rospy.loginfo("group arm: %d joints, mode %s", self.info.num_joints, self.info.mode)
        rospy.sleep(1.0)

    def on_state(self, msg):
        self.positions = dict(zip(msg.name, msg.position))

    def send(self, values):
        self.command.publish(JointGroupCommand(name="arm", cmd=values))

    def waist(self):
        return self.positions["waist"]

    def scan(self):
        """Turn at SPEED for SECONDS, then stop; how far the waist came."""
        joints = self.info.num_joints
        begin = self.waist()
        self.send([SPEED] + [0.0] * (joints - 1))
        rospy.sleep(SECONDS)
        self.send([0.0] * joints)
        turned = self.waist() - begin
        rospy.sleep(3.0)
        rospy.loginfo("turned %.2f rad, now at %.2f", turned, self.waist())
        return turned


def main():
    rospy.init_node("waist_scanner")
    scanner = Scanner()
    expected = SPEED * SECONDS
    for sweep in (1, 2):
        turned = scanner.scan()
        if abs(turned - expected) > ALLOWED:
            raise RuntimeError("sweep %d: turned %.2f rad instead of %.2f"
                               % (sweep, turned, expected))
    rospy.loginfo("scanned")


if __name__ == "__main__":
    main()
