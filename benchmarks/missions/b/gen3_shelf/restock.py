#!/usr/bin/env python3
# Restock a shelf with a Kinova Gen3: scan each box at the reader, then put it on the board.
# Talks to kortex_driver (ROS 1), after the examples of ros_kortex.
import threading

import rospy
from kortex_driver.msg import (ActionEvent, ActionNotification, ConstrainedPose, Finger,
                               GripperMode, CartesianSpeed)
from kortex_driver.srv import (Base_ClearFaults, ExecuteAction, ExecuteActionRequest,
                               OnNotificationActionTopic, OnNotificationActionTopicRequest,
                               ReadAction, ReadActionRequest, SendGripperCommand,
                               SendGripperCommandRequest)
from std_srvs.srv import Trigger

HOME_ACTION_IDENTIFIER = 2


class Robot:
    def __init__(self, name):
        self.finished = threading.Event()
        self.last_event = None
        base = "/" + name + "/base/"
        rospy.Subscriber("/" + name + "/action_topic", ActionNotification, self.on_notification)
        rospy.wait_for_service(base + "execute_action")
        self.clear_faults = rospy.ServiceProxy(base + "clear_faults", Base_ClearFaults)
        self.read_action = rospy.ServiceProxy(base + "read_action", ReadAction)
        self.execute_action = rospy.ServiceProxy(base + "execute_action", ExecuteAction)
        self.gripper_command = rospy.ServiceProxy(base + "send_gripper_command", SendGripperCommand)
        self.clear_faults()
        rospy.ServiceProxy(base + "activate_publishing_of_action_topic",
                           OnNotificationActionTopic)(OnNotificationActionTopicRequest())
        rospy.sleep(0.5)

    def on_notification(self, note):
        if note.action_event in (ActionEvent.ACTION_END, ActionEvent.ACTION_ABORT):
            self.last_event = note.action_event
            self.finished.set()

    def _execute(self, request):
        self.finished.clear()
        self.execute_action(request)
        if not self.finished.wait(20.0):
            rospy.logerr("the action did not end")
            return False
        return self.last_event == ActionEvent.ACTION_END

    def home(self):
        request = ReadActionRequest()
        request.input.identifier = HOME_ACTION_IDENTIFIER
        answer = self.read_action(request)
        execute = ExecuteActionRequest()
        execute.input = answer.output
        return self._execute(execute)

    def reach(self, x, y, z, speed=0.25):
        pose = ConstrainedPose()
        limit = CartesianSpeed()
        limit.translation = speed
        limit.orientation = 45.0
        pose.constraint.oneof_type.speed.append(limit)
        pose.target_pose.x = x
        pose.target_pose.y = y
        pose.target_pose.z = z
        pose.target_pose.theta_x = 180.0
        pose.target_pose.theta_y = 0.0
        pose.target_pose.theta_z = 90.0
        request = ExecuteActionRequest()
        request.input.oneof_action_parameters.reach_pose.append(pose)
        request.input.name = "reach"
        request.input.handle.action_type = 6
        request.input.handle.identifier = 1001
        return self._execute(request)

    def gripper(self, value):
        """0 is open, 1 is closed."""
        finger = Finger()
        finger.finger_identifier = 0
        finger.value = value
        request = SendGripperCommandRequest()
        request.input.gripper.finger.append(finger)
        request.input.mode = GripperMode.GRIPPER_POSITION
        self.gripper_command(request)
        rospy.sleep(1.5)


CARTON_X, CARTON_Y0, CARTON_DY = 0.45, -0.20, 0.12
SCANNER = (0.45, 0.05, 0.40)
BOARD_TOP = 0.10
GRIP_OVER_GROUND = 0.085
FACINGS = [(0.50, 0.30), (0.50, 0.19)]
HIGH = 0.40


class Restocker:
    def __init__(self):
        self.robot = Robot("my_gen3")
        self.scan = rospy.ServiceProxy("/scanner/read", Trigger)
        self.book = rospy.ServiceProxy("/stock/book", Trigger)

    def go(self, *args, **kwargs):
        if not self.robot.reach(*args, **kwargs):
            raise RuntimeError("pose %s was not reached" % (args,))

    def fetch(self, index):
        y = CARTON_Y0 + index * CARTON_DY
        self.go(CARTON_X, y, HIGH)
        self.go(CARTON_X, y, GRIP_OVER_GROUND + TIP, 0.15)
        self.robot.gripper(0.6)
        self.go(CARTON_X, y, HIGH, 0.15)

    def shelve(self, facing):
        x, y = facing
        z = BOARD_TOP + GRIP_OVER_GROUND + TIP
        self.go(x, y, z + 0.09)
        self.go(x, y, z + 0.002, 0.12)
        self.robot.gripper(0.0)
        self.go(x, y, z + 0.09, 0.15)

    def run(self):
        self.robot.home()
        self.robot.gripper(0.0)
        for index, facing in enumerate(FACINGS):
            self.fetch(index)
            self.go(*SCANNER)
            code = self.scan()
            if not code.success:
                rospy.logwarn("no code on box %d", index)
                continue
            self.shelve(facing)
            self.book()
        self.robot.home()


# From the tool frame that the driver reports to the point between the finger tips.
TIP = 0.135

if __name__ == "__main__":
    rospy.init_node("restock")
    Restocker().run()
