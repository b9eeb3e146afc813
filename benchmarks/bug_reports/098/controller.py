#!/usr/bin/env python3
"""Stir in three pots: the UR5e goes over a pot, then only the last wrist joint turns."""
import sys

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
POTS = [
    [-0.5, -1.4, 1.6, -1.77, -1.57, 0.0],
    [0.0, -1.4, 1.6, -1.77, -1.57, 0.0],
    [0.5, -1.4, 1.6, -1.77, -1.57, 0.0],
]


class Stirrer:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/arm_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        if not self.client.wait_for_server(rospy.Duration(10.0)):
            raise rospy.ROSException("no arm_controller")

    def move(self, names, stops):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = names
        for at, positions in stops:
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=positions, velocities=[0.0] * len(names),
                time_from_start=rospy.Duration(at)))
        state = self.client.send_goal_and_wait(goal)
        if state != GoalStatus.SUCCEEDED:
            raise RuntimeError("goal for %s ended in state %d" % (names, state))

    def stir(self):
        self.move(["wrist_3_joint"], [(1.5, [1.2]), (4.0, [-1.2]), (5.5, [0.0])])


def main():
    rospy.init_node("wrist_only")
    stirrer = Stirrer()
    for number, pot in enumerate(POTS, 1):
        stirrer.move(JOINTS, [(3.0, pot)])
        stirrer.stir()
        rospy.loginfo("pot %d stirred", number)
    return 0


if __name__ == "__main__":
    sys.exit(main())
