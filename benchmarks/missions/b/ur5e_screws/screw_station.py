#!/usr/bin/env python3
"""Screw the lid of a gearbox: four M5, UR5e with an automatic screwdriver (ROS 1).

The taught positions are in degrees, as read off the pendant.
"""
import math
import sys
from enum import Enum

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_msgs.msg import UInt8
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]

TAUGHT = {
    "park":         [0.00, -95.00, 95.00, -90.00, -90.00, 0.0],
    "feeder_above": [98.81, -89.77, 118.39, -118.63, -90.00, 0.0],
    "feeder":       [98.81, -84.53, 123.37, -128.84, -90.00, 0.0],
    "hole1_above":  [-16.58, -94.72, 131.79, -127.08, -90.00, 0.0],
    "hole1":        [-16.58, -88.45, 135.65, -137.19, -90.00, 0.0],
    "hole2_above":  [-13.72, -83.52, 120.36, -126.84, -90.00, 0.0],
    "hole2":        [-13.72, -78.29, 123.65, -135.36, -90.00, 0.0],
    "hole3_above":  [-1.59, -81.67, 118.19, -126.52, -90.00, 0.0],
    "hole3":        [-1.59, -76.60, 121.40, -134.80, -90.00, 0.0],
    "hole4_above":  [-1.92, -92.15, 129.44, -127.29, -90.00, 0.0],
    "hole4":        [-1.92, -86.13, 133.15, -137.02, -90.00, 0.0],
}

# Crosswise, so that the lid seats evenly.
SEQUENCE = [1, 3, 2, 4]
MAX_TRIES = 2


class S(Enum):
    FETCH = 0
    GO = 1
    TIGHTEN = 2
    LEAVE = 3
    NEXT = 4
    DONE = 5
    FAULT = 6


class Station:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.client.wait_for_server()
        self.feed = rospy.ServiceProxy("/feeder/next", Trigger)
        self.tighten = rospy.ServiceProxy("/screwdriver/tighten", Trigger)
        self.release = rospy.ServiceProxy("/screwdriver/release", Trigger)
        self.progress = rospy.Publisher("/station/screws_done", UInt8, queue_size=8)
        self.index = 0
        self.tries = 0
        self.table = {
            S.FETCH: self.on_fetch,
            S.GO: self.on_go,
            S.TIGHTEN: self.on_tighten,
            S.LEAVE: self.on_leave,
            S.NEXT: self.on_next,
        }

    @property
    def hole(self):
        return "hole%d" % SEQUENCE[self.index]

    def move(self, *legs):
        """Through taught positions; a leg is (name, seconds)."""
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        clock = 0.0
        for name, seconds in legs:
            clock += seconds
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=[math.radians(a) for a in TAUGHT[name]],
                velocities=[0.0] * 6,
                time_from_start=rospy.Duration(clock)))
        self.client.send_goal(goal)
        if not self.client.wait_for_result(rospy.Duration(clock + 5.0)):
            self.client.cancel_goal()
            raise rospy.ROSException("no result for %s" % (legs,))
        return self.client.get_result().error_code == 0

    def on_fetch(self):
        self.move(("feeder_above", 1.6), ("feeder", 0.7))
        self.feed()
        self.move(("feeder_above", 0.7))
        self.tries = 0
        return S.GO

    def on_go(self):
        self.move((self.hole + "_above", 1.6), (self.hole, 0.8))
        return S.TIGHTEN

    def on_tighten(self):
        self.tries += 1
        answer = self.tighten()
        if answer.success:
            return S.LEAVE
        rospy.logwarn("%s: %s", self.hole, answer.message)
        if self.tries >= MAX_TRIES:
            return S.FAULT
        self.release()
        return S.TIGHTEN

    def on_leave(self):
        self.move((self.hole + "_above", 0.6))
        return S.NEXT

    def on_next(self):
        self.index += 1
        self.progress.publish(self.index)
        return S.FETCH if self.index < len(SEQUENCE) else S.DONE

    def run(self):
        state = S.FETCH
        while state not in (S.DONE, S.FAULT) and not rospy.is_shutdown():
            state = self.table[state]()
        self.move(("park", 1.8))
        return state is S.DONE


if __name__ == "__main__":
    rospy.init_node("screw_station")
    sys.exit(0 if Station().run() else 1)
