#!/usr/bin/env python3
"""Endurance test of push buttons with an xArm6 (xarm_ros, ROS 1).

usage: button_test.py PRESSES BUTTON [BUTTON ...]
"""
import argparse
import functools
import math
import sys

import rospy
from std_msgs.msg import Int32
from std_srvs.srv import Trigger
from xarm_msgs.srv import Move, MoveRequest, SetAxis, SetInt16

BUTTONS = {"start": (320.0, -80.0), "reset": (320.0, 0.0), "stop": (320.0, 80.0), "lamp": (380.0, 0.0)}
FACE_MM = 210.0     # of the flange, when the pushing finger touches the buttons
STROKE_MM = 6.0
READY_MM = 40.0     # over the face
REST_DEG = [0.0, -20.0, -50.0, 0.0, 70.0, 0.0]


def checked(function):
    """An answer other than 0 of the driver is an error."""
    @functools.wraps(function)
    def wrapper(self, *args, **kwargs):
        answer = function(self, *args, **kwargs)
        if answer.ret != 0:
            raise RuntimeError("%s%r: ret %d %s" % (function.__name__, args, answer.ret, answer.message))
        return answer
    return wrapper


class XArm:
    def __init__(self, ns="/xarm"):
        proxy = lambda name, kind: rospy.ServiceProxy("%s/%s" % (ns, name), kind)
        self._motion, self._mode, self._state = (proxy("motion_ctrl", SetAxis), proxy("set_mode", SetInt16),
                                                 proxy("set_state", SetInt16))
        self._line, self._joint = proxy("move_line", Move), proxy("move_joint", Move)
        rospy.set_param(ns + "/wait_for_finish", True)

    def enable(self):
        self._motion(8, 1)
        self._mode(0)
        self._state(0)

    @checked
    def line(self, x, y, z, speed=150.0):
        return self._line(MoveRequest(pose=[x, y, z, math.pi, 0.0, 0.0], mvvelo=speed, mvacc=1000.0))

    @checked
    def joints(self, degrees, speed=40.0):
        return self._joint(MoveRequest(pose=[math.radians(d) for d in degrees],
                                       mvvelo=math.radians(speed), mvacc=5.0))


class Rig:
    def __init__(self):
        self.arm = rospy.ServiceProxy("/rig/arm", Trigger)
        self.read = rospy.ServiceProxy("/rig/read", Trigger)
        self.cycles = rospy.Publisher("/rig/cycles", Int32, queue_size=50)


def press(robot, rig, name):
    """One press; tells whether the contact closed."""
    x, y = BUTTONS[name]
    robot.line(x, y, FACE_MM - STROKE_MM, speed=60.0)
    closed = rig.read().message == "closed"
    robot.line(x, y, FACE_MM + 10.0, speed=100.0)
    return closed


def endure(robot, rig, name, presses):
    x, y = BUTTONS[name]
    robot.line(x, y, FACE_MM + READY_MM)
    rig.arm()
    good = 0
    for cycle in range(1, presses + 1):
        good += press(robot, rig, name)
        rig.cycles.publish(cycle)
    robot.line(x, y, FACE_MM + READY_MM)
    return good


def main(argv):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("presses", type=int)
    parser.add_argument("buttons", nargs="+", choices=sorted(BUTTONS))
    args = parser.parse_args(argv)

    rospy.init_node("button_test")
    robot, rig = XArm(), Rig()
    robot.enable()
    robot.joints(REST_DEG)
    results = {name: endure(robot, rig, name, args.presses) for name in args.buttons}
    robot.joints(REST_DEG)
    for name, good in results.items():
        rospy.loginfo("%s: %d of %d", name, good, args.presses)
    return 0 if all(good == args.presses for good in results.values()) else 2


if __name__ == "__main__":
    sys.exit(main(rospy.myargv(sys.argv)[1:]))
