#!/usr/bin/env python3
"""Turns the base of a Kinova Gen3 by an angular waypoint (kortex_driver)."""
import rospy
from kortex_driver.msg import (ActionEvent, ActionNotification, AngularWaypoint, BaseCyclic_Feedback,
                               Waypoint, WaypointList)
from kortex_driver.srv import (ExecuteAction, ExecuteActionRequest, OnNotificationActionTopic,
                               OnNotificationActionTopicRequest)

NAME = "/my_gen3"
DURATION = 0.2


class Turn:
    def __init__(self):
        self.event = None
        rospy.Subscriber(NAME + "/action_topic", ActionNotification, self.on_event)
        self.execute = rospy.ServiceProxy(NAME + "/base/execute_action", ExecuteAction)
        self.execute.wait_for_service()
        notify = rospy.ServiceProxy(
            NAME + "/base/activate_publishing_of_action_topic", OnNotificationActionTopic)
        notify(OnNotificationActionTopicRequest())
        rospy.sleep(1.0)

    def on_event(self, message):
        self.event = message.action_event

    def angles(self):
        feedback = rospy.wait_for_message(NAME + "/base_feedback", BaseCyclic_Feedback)
        return [actuator.position for actuator in feedback.actuators]

    def run(self):
        target = self.angles()
        target[0] = (target[0] + 90.0) % 360.0
        angular = AngularWaypoint(angles=target, duration=DURATION)
        waypoint = Waypoint()
        waypoint.oneof_type_of_waypoint.angular_waypoint.append(angular)
        waypoints = WaypointList(duration=0, use_optimal_blending=False)
        waypoints.waypoints.append(waypoint)
        request = ExecuteActionRequest()
        request.input.oneof_action_parameters.execute_waypoint_list.append(waypoints)
        self.execute(request)
        for _ in range(100):
            if self.event == ActionEvent.ACTION_END:
                return True
            if self.event == ActionEvent.ACTION_ABORT:
                return False
            rospy.sleep(0.1)
        return False


def main():
    rospy.init_node("gen3_turn")
    if Turn().run():
        rospy.loginfo("turned")
    else:
        rospy.logerr("not turned")


if __name__ == "__main__":
    main()
