#!/usr/bin/env python3
"""Moves an xArm 6 to a joint pose and home again by the services of xarm_api."""
import rospy
from xarm_msgs.srv import Move, MoveRequest, SetAxis, SetInt16

POSE = [0.5, -0.4, -0.4, 0.0, 0.8, 0.0]


def service(name, kind):
    rospy.wait_for_service(name)
    return rospy.ServiceProxy(name, kind)


def main():
    rospy.init_node("xarm6_there_and_back")
    rospy.set_param("/xarm/wait_for_finish", True)
    service("/xarm/motion_ctrl", SetAxis)(8, 1)
    service("/xarm/set_mode", SetInt16)(1)
    service("/xarm/set_state", SetInt16)(0)

    request = MoveRequest()
    request.pose = POSE
    request.mvvelo = 0.5
    request.mvacc = 7.0
    request.mvtime = 0
    request.mvradii = 0
    answer = service("/xarm/move_joint", Move)(request)
    rospy.loginfo("move_joint: ret %d", answer.ret)
    rospy.sleep(3.0)

    request.pose = []
    answer = service("/xarm/go_home", Move)(request)
    rospy.loginfo("go_home: ret %d", answer.ret)
    rospy.sleep(3.0)


if __name__ == "__main__":
    main()
