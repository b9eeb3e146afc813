#!/usr/bin/env python3
# Camera inspection with a Kinova Gen3: the Kortex driver's services (ROS 1), angles in degrees.
import threading

import rospy
from geometry_msgs.msg import PoseStamped
from inspect_msgs.srv import Capture
from kortex_driver.msg import Action, ActionEvent, ActionNotification, ActionType, ConstrainedJointAngles, JointAngle
from kortex_driver.srv import (Base_ClearFaults, ExecuteAction, ExecuteActionRequest,
                               OnNotificationActionTopic, OnNotificationActionTopicRequest)
from std_msgs.msg import Float32MultiArray, UInt16

ROBOT = "my_gen3"

# view number -> joint angles [deg]
VIEWS = {
    1: (333.73, 25.82, 168.48, 237.58, 320.00, 67.45, 114.01),
    2: (0.89, 19.72, 179.30, 226.31, 0.36, 63.45, 90.01),
    3: (26.87, 25.15, 191.35, 237.08, 40.76, 67.51, 65.62),
}
CLOSE_UP = (22.69, 30.34, 189.85, 247.97, 36.42, 60.66, 64.23)
HOME = (0.0, 14.90, 179.91, 229.94, 0.0, 55.00, 89.95)

# where each view looks, in base_link [m]
LOOKS_AT = {1: (0.75, 0.20), 2: (0.75, 0.00), 3: (0.75, -0.20)}


class Base:
    """The part of the Kortex API that is needed: go to joint angles, and wait for the notification."""

    def __init__(self, name):
        self._done = threading.Event()
        self._last = None
        prefix = "/" + name
        rospy.Subscriber(prefix + "/action_topic", ActionNotification, self._notified)
        rospy.wait_for_service(prefix + "/base/execute_action")
        self._execute = rospy.ServiceProxy(prefix + "/base/execute_action", ExecuteAction)
        rospy.ServiceProxy(prefix + "/base/clear_faults", Base_ClearFaults)()
        subscribe = rospy.ServiceProxy(prefix + "/base/activate_publishing_of_action_topic", OnNotificationActionTopic)
        subscribe(OnNotificationActionTopicRequest())
        rospy.sleep(0.3)

    def _notified(self, message):
        self._last = message.action_event
        if message.action_event in (ActionEvent.ACTION_END, ActionEvent.ACTION_ABORT):
            self._done.set()

    def reach(self, degrees, name=""):
        angles = ConstrainedJointAngles()
        for number, value in enumerate(degrees):
            angles.joint_angles.joint_angles.append(JointAngle(joint_identifier=number, value=value))
        request = ExecuteActionRequest()
        request.input.name = name
        request.input.handle.action_type = ActionType.REACH_JOINT_ANGLES
        request.input.oneof_action_parameters.reach_joint_angles.append(angles)
        self._done.clear()
        self._execute(request)
        if not self._done.wait(30.0):
            raise RuntimeError("no end of the action " + name)
        return self._last == ActionEvent.ACTION_END


class Inspector:
    EXPOSURE_MS = 8.0

    def __init__(self, base, part_id):
        self.base = base
        self.part_id = part_id
        self.defects = {}
        self.capture = rospy.ServiceProxy("/camera/capture", Capture)
        self.light = rospy.Publisher("/light/levels", Float32MultiArray, queue_size=4)
        self.spot = rospy.Publisher("/inspection/defect_at", PoseStamped, queue_size=4)
        self.total = rospy.Publisher("/inspection/defects", UInt16, queue_size=4)

    def look(self, view):
        self.base.reach(VIEWS[view], "view %d" % view)
        self.light.publish(data=[0.8, 0.8, 0.25])
        rospy.sleep(0.25)  # settle
        exposure = self.EXPOSURE_MS
        picture = self.capture(self.part_id, view, exposure)
        while not picture.sharp and exposure < 40.0:
            exposure *= 2
            picture = self.capture(self.part_id, view, exposure)
        if picture.defects:
            self.defects[view] = picture.defects
            self.tell(view)
        return picture.defects

    def tell(self, view):
        message = PoseStamped()
        message.header.frame_id = "base_link"
        message.pose.position.x, message.pose.position.y = LOOKS_AT[view]
        message.pose.position.z = 0.40
        message.pose.orientation.w = 1.0
        self.spot.publish(message)

    def run(self):
        for view in sorted(VIEWS):
            if self.look(view) > 2:
                self.base.reach(CLOSE_UP, "close up")
                self.capture(self.part_id, 9, self.EXPOSURE_MS)
        self.base.reach(HOME, "home")
        self.light.publish(data=[0.0, 0.0, 0.0])
        self.total.publish(sum(self.defects.values()))


def main():
    rospy.init_node("inspector")
    inspector = Inspector(Base(ROBOT), rospy.get_param("~part_id"))
    inspector.base.reach(HOME, "home")
    inspector.run()
    rospy.sleep(0.2)


if __name__ == "__main__":
    main()
