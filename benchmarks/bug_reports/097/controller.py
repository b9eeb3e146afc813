#!/usr/bin/env python3
"""Look at a weld from several sides: the UR5e goes there, then only its wrist moves."""
import sys

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

ARM = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"]
WRIST = ["wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
AT_WELD = [0.5, -1.3, 1.5, -1.8, -1.57, 0.0]
LOOKS = [[-1.5, -1.3, 0.4], [-2.1, -1.8, -0.4], [-1.8, -1.57, 0.0]]


class Inspection:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/arm_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.client.wait_for_server()

    def move(self, names, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = names
        point = JointTrajectoryPoint()
        point.positions = positions
        point.velocities = [0.0] * len(names)
        point.time_from_start = rospy.Duration(seconds)
        goal.trajectory.points.append(point)
        self.client.send_goal(goal)
        self.client.wait_for_result(rospy.Duration(seconds + 5.0))

    def inspect(self):
        self.move(ARM + WRIST, AT_WELD, 4.0)
        for number, look in enumerate(LOOKS, 1):
            self.move(WRIST, look, 2.0)
            rospy.loginfo("picture %d taken", number)
            rospy.sleep(0.5)


def main():
    rospy.init_node("wrist_inspection")
    Inspection().inspect()
    return 0


if __name__ == "__main__":
    sys.exit(main())
