#!/usr/bin/env python3
"""Go to a place, let somebody guide the arm by hand, and go on (xArm 6, services of xarm_api)."""
import sys

import rospy
from xarm_msgs.srv import Move, MoveRequest, SetAxis, SetInt16

POSITION, TEACHING = 0, 2
READY = 0
FIRST = [0.0, -0.4, -0.6, 0.0, 1.0, 0.0]
SECOND = [0.8, -0.4, -0.6, 0.0, 1.0, 0.0]
THIRD = [0.8, -0.7, -0.4, 0.0, 1.1, 0.5]


class Arm:
    def __init__(self, ns="/xarm/"):
        rospy.set_param(ns + "wait_for_finish", True)
        self.enable = self.proxy(ns + "motion_ctrl", SetAxis)
        self.mode = self.proxy(ns + "set_mode", SetInt16)
        self.state = self.proxy(ns + "set_state", SetInt16)
        self.move = self.proxy(ns + "move_joint", Move)

    @staticmethod
    def proxy(name, kind):
        rospy.wait_for_service(name)
        return rospy.ServiceProxy(name, kind)

    def start(self):
        self.enable(8, 1)
        self.mode(POSITION)
        self.state(READY)

    def go(self, name, joints):
        answer = self.move(MoveRequest(pose=joints, mvvelo=0.5, mvacc=7.0, mvtime=0, mvradii=0))
        rospy.loginfo("%s: ret %d", name, answer.ret)

    def guided_by_hand(self, seconds):
        self.mode(TEACHING)
        self.state(READY)
        rospy.loginfo("guide me")
        rospy.sleep(seconds)
        answer = self.mode(POSITION)
        rospy.loginfo("back in position mode: ret %d", answer.ret)


def main():
    rospy.init_node("teach_and_go")
    arm = Arm()
    arm.start()
    arm.go("first", FIRST)
    arm.guided_by_hand(3.0)
    arm.go("second", SECOND)
    arm.go("third", THIRD)
    rospy.loginfo("finished")
    return 0


if __name__ == "__main__":
    sys.exit(main())
