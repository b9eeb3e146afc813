#!/usr/bin/env python
# -*- coding: utf-8 -*-
"""Put two onigiri boxes into the bento tray, xArm 6 with the box's services (xarm_api, ROS 1).

Positions in mm, angles in rad, like in UFactory Studio.
"""
from __future__ import print_function

import math

import rospy
from std_msgs.msg import String
from std_srvs.srv import Trigger
from xarm_msgs.srv import GripperConfig, GripperMove, Move, SetAxis, SetInt16

NS = "/xarm"
DOWN = (math.pi, 0.0, 0.0)
LINE_SPEED = 180.0      # mm/s
LINE_ACC = 1200.0       # mm/s^2
SAFE_Z = 300.0

OPEN, CLOSED = 850.0, 250.0    # gripper pulses

PICKS = [(330.0, -160.0), (330.0, -60.0)]
TRAY = {"left": (300.0, 150.0), "right": (300.0, 230.0)}
ORDER = ["left", "right"]
GRIP_Z = 190.0


def proxy(name, kind):
    full = NS + "/" + name
    rospy.wait_for_service(full, timeout=5.0)
    return rospy.ServiceProxy(full, kind)


def check(answer, what):
    if answer.ret != 0:
        raise RuntimeError("%s: code %d %s" % (what, answer.ret, answer.message))


def enable():
    rospy.set_param(NS + "/wait_for_finish", True)
    check(proxy("motion_ctrl", SetAxis)(8, 1), "motion_ctrl")
    check(proxy("set_mode", SetInt16)(0), "set_mode")
    check(proxy("set_state", SetInt16)(0), "set_state")
    check(proxy("gripper_config", GripperConfig)(1500.0), "gripper_config")


def line(x, y, z, speed=LINE_SPEED):
    pose = [x, y, z] + list(DOWN)
    check(move_line(pose, speed, LINE_ACC, 0.0, 0.0), "move_line")


def over(x, y):
    line(x, y, SAFE_Z)


def dip(x, y, z, pulse):
    """Down, gripper, up."""
    line(x, y, z, LINE_SPEED / 2)
    check(gripper(pulse), "gripper")
    rospy.sleep(0.3)
    line(x, y, SAFE_Z, LINE_SPEED / 2)


def transfer(number, place):
    px, py = PICKS[number]
    tx, ty = TRAY[place]
    over(px, py)
    dip(px, py, GRIP_Z, CLOSED)
    over(tx, ty)
    dip(tx, ty, GRIP_Z + 2.0, OPEN)


if __name__ == "__main__":
    rospy.init_node("bento")
    status = rospy.Publisher("/bento/status", String, queue_size=10)
    enable()
    move_line = proxy("move_line", Move)
    gripper = proxy("gripper_move", GripperMove)
    next_tray = rospy.ServiceProxy("/line/next_tray", Trigger)

    check(gripper(OPEN), "gripper")
    for i, place in enumerate(ORDER):
        status.publish("packing %s" % place)
        transfer(i, place)
    over(*TRAY["left"])
    next_tray()
    status.publish("tray full")
    print("done")
