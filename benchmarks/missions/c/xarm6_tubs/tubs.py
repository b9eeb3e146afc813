#!/usr/bin/env python3
"""Swap tubs between filler and cooler with an xArm6 and its gripper: the maker's services (ROS 1), mm and rad."""
import functools
import math
from collections import deque

import rospy
from std_msgs.msg import ColorRGBA, Float32, UInt16
from std_srvs.srv import SetBool
from xarm_msgs.srv import ClearErr, GripperConfig, GripperMove, Move, SetAxis, SetInt16

ROLL, PITCH = math.pi, 0.0
FLANGE_MM = 172.0  # the box speaks of the flange, the fingers are below
SAFE_MM = 230.0
OPEN_PULSE, SHUT_PULSE = 700, 350
READY = [0.0, -0.25, -0.95, 0.0, 1.2, 0.0]

FILLER = (380.0, -180.0)
COOLER = [(330.0, 170.0), (430.0, 170.0)]
DECK_MM = 75.0

GREEN = (0.0, 1.0, 0.0)
AMBER = (1.0, 0.6, 0.0)

COOL_TO_C = 6.0
KELVIN = 273.15


class ArmFault(RuntimeError):
    pass


def checked(call):
    """The services answer with `ret`; 0 is good."""

    @functools.wraps(call)
    def wrapper(*args, **kwargs):
        answer = call(*args, **kwargs)
        if answer.ret != 0:
            raise ArmFault("%s: ret %d, %s" % (call.resolved_name, answer.ret, answer.message))
        return answer

    return wrapper


def again(times):
    """Try a motion again after clearing the error."""

    def decorate(function):
        @functools.wraps(function)
        def wrapper(self, *args, **kwargs):
            for attempt in range(times):
                try:
                    return function(self, *args, **kwargs)
                except ArmFault as fault:
                    rospy.logwarn("attempt %d: %s", attempt + 1, fault)
                    self.reset()
            raise ArmFault("%s gave up" % function.__name__)

        return wrapper

    return decorate


class XArm:
    def __init__(self, ns="/xarm"):
        rospy.wait_for_service(ns + "/move_line")
        proxy = lambda name, kind: checked(rospy.ServiceProxy(ns + "/" + name, kind))
        self._line = proxy("move_line", Move)
        self._joints = proxy("move_joint", Move)
        self._axis = proxy("motion_ctrl", SetAxis)
        self._mode = proxy("set_mode", SetInt16)
        self._state = proxy("set_state", SetInt16)
        self._clear = proxy("clear_err", ClearErr)
        self._speed = proxy("gripper_config", GripperConfig)
        self._grip = proxy("gripper_move", GripperMove)

    def reset(self):
        self._clear()
        self._axis(8, 1)
        self._mode(0)
        self._state(0)

    def gripper_speed(self, pulses):
        self._speed(pulses)

    def gripper(self, pulse):
        self._grip(pulse)
        rospy.sleep(0.3)

    def ready(self):
        self._joints(READY, 0.8, 8.0, 0.0, 0.0)

    @again(2)
    def line(self, x, y, z, speed=200.0):
        self._line([x, y, z + FLANGE_MM, ROLL, PITCH, 0.0], speed, 800.0, 0.0, 0.0)


class Cell:
    def __init__(self):
        self.arm = XArm()
        self.lamp = rospy.Publisher("/lamp", ColorRGBA, queue_size=4)
        self.count = rospy.Publisher("/cooler/filled", UInt16, queue_size=4)
        self.setpoint = rospy.Publisher("/cooler/setpoint", Float32, queue_size=4)  # in kelvin
        self.fan = rospy.ServiceProxy("/cooler/fan", SetBool)
        self.free = deque(COOLER)
        self.filled = 0

    def show(self, rgb):
        self.lamp.publish(ColorRGBA(rgb[0], rgb[1], rgb[2], 1.0))

    def above(self, xy):
        self.arm.line(xy[0], xy[1], SAFE_MM)

    def transfer(self, source):
        """A tub from the source to the next free place of the cooler."""
        target = self.free.popleft()
        self.arm.gripper(OPEN_PULSE)
        self.above(source)
        self.arm.line(source[0], source[1], DECK_MM, speed=90.0)
        self.arm.gripper(SHUT_PULSE)
        self.above(source)
        self.above(target)
        self.arm.line(target[0], target[1], DECK_MM + 2.0, speed=90.0)
        self.arm.gripper(OPEN_PULSE)
        self.above(target)
        self.filled += 1
        self.count.publish(self.filled)


def main():
    rospy.init_node("tubs")
    cell = Cell()
    cell.arm.reset()
    cell.arm.gripper_speed(3000)
    cell.show(AMBER)
    cell.arm.ready()
    sources = (FILLER, (FILLER[0] + 100.0, FILLER[1]))
    for source in sources:
        cell.transfer(source)
    cell.setpoint.publish(COOL_TO_C + KELVIN)
    cell.fan(True)
    cell.above((350.0, 0.0))
    cell.show(GREEN)
    rospy.sleep(0.2)


if __name__ == "__main__":
    main()
