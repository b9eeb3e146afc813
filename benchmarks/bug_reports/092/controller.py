#!/usr/bin/env python3
"""Close the gripper of a Gen3 at its home position and turn the wrist (kortex_driver, ROS 1)."""
import sys

import rospy
from kortex_driver.msg import (ActionEvent, ActionNotification, ActionType, ConstrainedJointAngles,
                               Finger, GripperMode, JointAngle)
from kortex_driver.srv import (ExecuteAction, ExecuteActionRequest, OnNotificationActionTopic,
                               OnNotificationActionTopicRequest, ReadAction, ReadActionRequest,
                               SendGripperCommand, SendGripperCommandRequest)

ROBOT = "/my_gen3"
TURNED = [0.0, 15.0, 180.0, 230.0, 0.0, 55.0, 150.0]  # degrees


class Gripping:
    def __init__(self):
        self.last = None
        rospy.Subscriber(ROBOT + "/action_topic", ActionNotification, self.on_notification)
        self.read = self.proxy("read_action", ReadAction)
        self.execute = self.proxy("execute_action", ExecuteAction)
        self.gripper = self.proxy("send_gripper_command", SendGripperCommand)
        activate = self.proxy("activate_publishing_of_action_topic", OnNotificationActionTopic)
        activate(OnNotificationActionTopicRequest())
        rospy.sleep(1.0)

    def proxy(self, name, kind):
        full = ROBOT + "/base/" + name
        rospy.wait_for_service(full)
        return rospy.ServiceProxy(full, kind)

    def on_notification(self, notification):
        self.last = notification.action_event

    def finished(self):
        """Wait for the end of what was sent last."""
        rate = rospy.Rate(50)
        while not rospy.is_shutdown():
            if self.last in (ActionEvent.ACTION_END, ActionEvent.ACTION_ABORT):
                return self.last == ActionEvent.ACTION_END
            rate.sleep()

    def home(self):
        wanted = ReadActionRequest()
        wanted.input.identifier = 2
        request = ExecuteActionRequest()
        request.input = self.read(wanted).output
        self.last = None
        self.execute(request)
        return self.finished()

    def grip(self, closed):
        finger = Finger()
        finger.finger_identifier = 0
        finger.value = closed
        request = SendGripperCommandRequest()
        request.input.mode = GripperMode.GRIPPER_POSITION
        request.input.gripper.finger.append(finger)
        self.last = None
        self.gripper(request)
        return self.finished()

    def turn(self):
        goal = ConstrainedJointAngles()
        for joint, value in enumerate(TURNED):
            angle = JointAngle()
            angle.joint_identifier = joint
            angle.value = value
            goal.joint_angles.joint_angles.append(angle)
        request = ExecuteActionRequest()
        request.input.name = "turn"
        request.input.handle.action_type = ActionType.REACH_JOINT_ANGLES
        request.input.oneof_action_parameters.reach_joint_angles.append(goal)
        self.last = None
        self.execute(request)
        return self.finished()


def main():
    rospy.init_node("gen3_gripping")
    cell = Gripping()
    rospy.loginfo("at home: %s", cell.home())
    rospy.loginfo("closed: %s", cell.grip(0.7))
    rospy.loginfo("turned: %s", cell.turn())
    rospy.loginfo("opened: %s", cell.grip(0.0))
    return 0


if __name__ == "__main__":
    sys.exit(main())
