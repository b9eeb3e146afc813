#!/usr/bin/env python3
"""Feed a press with a Kinova Gen3 through the actions of kortex_driver."""
import sys
import time

import rospy
from kortex_driver.msg import (ActionEvent, ActionNotification, ActionType, CartesianSpeed,
                               ConstrainedPose)
from kortex_driver.srv import (Base_ClearFaults, ExecuteAction, ExecuteActionRequest,
                               OnNotificationActionTopic, OnNotificationActionTopicRequest,
                               ReadAction, ReadActionRequest)

HOME = 2
ABOVE_TRAY = (0.45, 0.10, 0.40, 90.0, 0.0, 90.0)
AT_PRESS = (0.45, -0.15, 0.40, 90.0, 0.0, 90.0)


class Feeder:
    def __init__(self):
        base = "/my_gen3/base/"
        self.event = None
        rospy.Subscriber("/my_gen3/action_topic", ActionNotification, self.on_event)
        for name in ("clear_faults", "read_action", "execute_action",
                     "activate_publishing_of_action_topic"):
            rospy.wait_for_service(base + name)
        self.clear_faults = rospy.ServiceProxy(base + "clear_faults", Base_ClearFaults)
        self.read = rospy.ServiceProxy(base + "read_action", ReadAction)
        self.execute = rospy.ServiceProxy(base + "execute_action", ExecuteAction)
        self.notify = rospy.ServiceProxy(base + "activate_publishing_of_action_topic",
                                         OnNotificationActionTopic)

    def on_event(self, msg):
        self.event = msg.action_event

    def wait_until_done(self):
        while not rospy.is_shutdown():
            if self.event == ActionEvent.ACTION_END:
                return True
            if self.event == ActionEvent.ACTION_ABORT:
                return False
            time.sleep(0.02)
        return False

    def go_home(self):
        stored = ReadActionRequest()
        stored.input.identifier = HOME
        request = ExecuteActionRequest()
        request.input = self.read(stored).output
        self.event = None
        self.execute(request)
        return self.wait_until_done()

    def go_to(self, number, place):
        speed = CartesianSpeed()
        speed.translation = 0.15
        speed.orientation = 20.0
        pose = ConstrainedPose()
        pose.constraint.oneof_type.speed.append(speed)
        target = pose.target_pose
        (target.x, target.y, target.z, target.theta_x, target.theta_y, target.theta_z) = place
        request = ExecuteActionRequest()
        request.input.name = "place%d" % number
        request.input.handle.identifier = 1000 + number
        request.input.handle.action_type = ActionType.REACH_POSE
        request.input.oneof_action_parameters.reach_pose.append(pose)
        self.event = None
        self.execute(request)
        return self.wait_until_done()

    def listen(self):
        self.notify(OnNotificationActionTopicRequest())
        rospy.sleep(0.5)


def main():
    rospy.init_node("gen3_feeder")
    feeder = Feeder()
    feeder.clear_faults()
    rospy.sleep(1.0)
    rospy.loginfo("home: %s", feeder.go_home())
    feeder.listen()
    for number, place in enumerate((ABOVE_TRAY, AT_PRESS, ABOVE_TRAY)):
        rospy.loginfo("place %d: %s", number, feeder.go_to(number, place))
    return 0


if __name__ == "__main__":
    sys.exit(main())
