#!/usr/bin/env python3
# Press line: Kinova Gen3 carries blanks from the feeder into the press and on to the outfeed.
# The arm is driven through Kinova's own driver (kortex_driver), so poses are in m and degrees.
import queue
import threading

import rospy
from kortex_driver.msg import (ActionNotification, ActionEvent, ActionType, ConstrainedPose, Finger, Gripper,
                               GripperMode, CartesianSpeed)
from kortex_driver.srv import (ExecuteAction, ExecuteActionRequest, OnNotificationActionTopic,
                               OnNotificationActionTopicRequest, ReadAction, ReadActionRequest,
                               SendGripperCommand, SendGripperCommandRequest)
from std_msgs.msg import Int32
from std_srvs.srv import SetBool, Trigger

NS = "/my_gen3"
PADS = 0.142          # flange to finger pads [m]

FEEDER = {1: (0.40, -0.20), 2: (0.48, -0.20)}
PRESS = (0.45, 0.15)
OUTFEED = {1: (0.30, 0.30), 2: (0.38, 0.30)}
OPEN, SHUT = 0.3, 0.75
GRIP_Z = 0.028
CLEAR_Z = 0.15

HOME_ACTION = 2


class Gen3:
    """Blocking motions of the arm."""

    def __init__(self):
        self.ended = threading.Event()
        self.outcome = None
        rospy.Subscriber(NS + "/action_topic", ActionNotification, self.on_notification)
        self.execute = rospy.ServiceProxy(NS + "/base/execute_action", ExecuteAction)
        self.read = rospy.ServiceProxy(NS + "/base/read_action", ReadAction)
        self.grip = rospy.ServiceProxy(NS + "/base/send_gripper_command", SendGripperCommand)
        rospy.ServiceProxy(NS + "/base/activate_publishing_of_action_topic",
                           OnNotificationActionTopic)(OnNotificationActionTopicRequest())

    def on_notification(self, note):
        if note.action_event in (ActionEvent.ACTION_END, ActionEvent.ACTION_ABORT):
            self.outcome = note.action_event
            self.ended.set()

    def _run(self, request):
        self.ended.clear()
        self.execute(request)
        if not self.ended.wait(20.0):
            raise RuntimeError("the motion does not end")
        if self.outcome != ActionEvent.ACTION_END:
            raise RuntimeError("the motion was aborted")

    def home(self):
        action = ReadActionRequest()
        action.input.identifier = HOME_ACTION
        request = ExecuteActionRequest()
        request.input = self.read(action).output
        self._run(request)

    def to(self, xy, z, speed=0.2):
        target = ConstrainedPose()
        target.target_pose.x, target.target_pose.y = xy
        target.target_pose.z = z + PADS
        target.target_pose.theta_x = 180.0
        target.target_pose.theta_y = 0.0
        target.target_pose.theta_z = 90.0
        limit = CartesianSpeed()
        limit.translation = speed
        limit.orientation = 30.0
        target.constraint.oneof_type.speed.append(limit)
        request = ExecuteActionRequest()
        request.input.name = "to"
        request.input.handle.action_type = ActionType.REACH_POSE
        request.input.oneof_action_parameters.reach_pose.append(target)
        self._run(request)

    def fingers(self, closed):
        """closed: 0 open ... 1 shut"""
        request = SendGripperCommandRequest()
        request.input.gripper.finger.append(Finger(finger_identifier=0, value=closed))
        request.input.mode = GripperMode.GRIPPER_POSITION
        self.grip(request)
        rospy.sleep(1.8)  # the driver does not wait


class Line(threading.Thread):
    """Takes jobs from the queue until None comes."""

    def __init__(self, jobs):
        super().__init__(name="line")
        self.jobs = jobs
        self.arm = Gen3()
        self.press = rospy.ServiceProxy("/press/start", Trigger)
        self.safe = rospy.ServiceProxy("/press/safe", SetBool)
        self.finished = rospy.Publisher("/line/finished", Int32, queue_size=10)

    def run(self):
        self.arm.home()
        while True:
            number = self.jobs.get()
            if number is None:
                break
            self.carry(FEEDER[number], PRESS)
            self.stroke()
            self.carry(PRESS, OUTFEED[number])
            self.finished.publish(number)
        self.arm.home()

    def carry(self, source, target):
        self.arm.fingers(OPEN)
        self.arm.to(source, CLEAR_Z)
        self.arm.to(source, GRIP_Z, 0.1)
        self.arm.fingers(SHUT)
        self.arm.to(source, CLEAR_Z)
        self.arm.to(target, CLEAR_Z)
        self.arm.to(target, GRIP_Z + 0.001, 0.1)
        self.arm.fingers(OPEN)
        self.arm.to(target, CLEAR_Z)

    def stroke(self):
        """Out of the press, stroke, and back over it."""
        self.arm.to(OUTFEED[1], CLEAR_Z)
        self.safe(True)
        done = self.press()
        self.safe(False)
        if not done.success:
            raise RuntimeError("the press: " + done.message)


def main():
    rospy.init_node("press_line")
    jobs = queue.Queue()
    line = Line(jobs)
    line.start()
    for number in (1, 2):
        jobs.put(number)
    jobs.put(None)
    line.join()
    rospy.loginfo("shift is over")


if __name__ == "__main__":
    main()
