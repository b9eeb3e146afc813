#!/usr/bin/env python3
"""A service without fields in its response: park the UR5e, or bring it out again."""
import sys

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_srvs.srv import Empty, EmptyResponse
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
PARKED = [0.0, -2.2, 2.4, -1.77, -1.57, 0.0]
WORK = [0.6, -1.4, 1.6, -1.77, -1.57, 0.0]


class Parking:
    def __init__(self):
        self.arm = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.arm.wait_for_server()
        self.served = 0
        rospy.Service("/cell/park", Empty, self.on_park)
        rospy.Service("/cell/work", Empty, self.on_work)
        rospy.loginfo("serving")

    def go(self, positions):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(3.0))]
        return self.arm.send_goal_and_wait(goal)

    def answer(self, what, positions):
        state = self.go(positions)
        self.served += 1
        rospy.loginfo("%s: state %d (call %d)", what, state, self.served)
        return EmptyResponse()

    def on_park(self, _):
        return self.answer("parked", PARKED)

    def on_work(self, _):
        return self.answer("at work", WORK)


def main():
    rospy.init_node("parking_service")
    Parking()
    rospy.spin()


if __name__ == "__main__":
    main()
