#! /usr/bin/env python
# Open-day demo with the Jaco of the lab: plays back what was taught by hand.
# usage: show_and_tell.py    (start by: rostopic pub /demo/start std_msgs/Empty)
import functools

import actionlib
import rospy
from kinova_msgs.msg import (ArmJointAnglesAction, ArmJointAnglesGoal, SetFingersPositionAction,
                             SetFingersPositionGoal)
from std_msgs.msg import Empty, String
from std_srvs.srv import Trigger

PREFIX = "j2n6s300"
FINGER_TURN = 6800.0        # of a closed finger

# joint angles in degrees, recorded with `rostopic echo .../out/joint_angles`
HOME = (275.30, 167.59, 57.41, 240.81, 82.85, 75.80)
BOW = (275.30, 200.0, 75.0, 240.0, 82.0, 75.0)
LEFT = (305.0, 175.0, 70.0, 230.0, 85.0, 75.0)
RIGHT = (245.0, 175.0, 70.0, 250.0, 80.0, 75.0)
BUTTON_NEAR = (260.0, 185.0, 95.0, 225.0, 110.0, 60.0)
BUTTON_IN = (260.0, 196.0, 104.0, 225.0, 112.0, 60.0)


def announced(text):
    """Tell the kiosk screen what happens."""
    def wrap(function):
        @functools.wraps(function)
        def inner(self, *args, **kwargs):
            self.screen.publish(text)
            return function(self, *args, **kwargs)
        return inner
    return wrap


class Demo(object):
    def __init__(self):
        self.arm = actionlib.SimpleActionClient(
            "/%s_driver/joints_action/joint_angles" % PREFIX, ArmJointAnglesAction)
        self.fingers = actionlib.SimpleActionClient(
            "/%s_driver/fingers_action/finger_positions" % PREFIX, SetFingersPositionAction)
        self.arm.wait_for_server()
        self.fingers.wait_for_server()
        self.screen = rospy.Publisher("/kiosk/screen", String, queue_size=10)
        self.confirm = rospy.ServiceProxy("/lift/press_confirmed", Trigger)
        self.photo = rospy.ServiceProxy("/kiosk/photo", Trigger)

    def joints(self, angles, patience=25.0):
        goal = ArmJointAnglesGoal()
        for number, angle in enumerate(angles, 1):
            setattr(goal.angles, "joint%d" % number, angle)
        self.arm.send_goal(goal)
        if not self.arm.wait_for_result(rospy.Duration(patience)):
            self.arm.cancel_all_goals()
            raise RuntimeError("arm is stuck")

    def hand(self, percent):
        turn = percent / 100.0 * FINGER_TURN
        goal = SetFingersPositionGoal()
        goal.fingers.finger1 = turn
        goal.fingers.finger2 = turn
        goal.fingers.finger3 = turn
        self.fingers.send_goal(goal)
        self.fingers.wait_for_result(rospy.Duration(8.0))

    @announced("Hello!")
    def greet(self):
        self.joints(BOW)
        self.joints(HOME)

    @announced("Look left, look right")
    def look_around(self, times=2):
        for _ in range(times):
            self.joints(LEFT)
            self.joints(RIGHT)
        self.photo()

    @announced("Calling the lift")
    def press_button(self):
        self.hand(100)
        self.joints(BUTTON_NEAR)
        self.joints(BUTTON_IN)
        answer = self.confirm()
        self.joints(BUTTON_NEAR)
        self.hand(20)
        return answer.success

    @announced("Thank you")
    def finish(self):
        self.joints(HOME)


def main():
    rospy.init_node("show_and_tell")
    demo = Demo()
    rospy.wait_for_message("/demo/start", Empty)
    demo.greet()
    demo.look_around()
    if not demo.press_button():
        rospy.logerr("the lift does not answer")
    demo.finish()


if __name__ == "__main__":
    main()
