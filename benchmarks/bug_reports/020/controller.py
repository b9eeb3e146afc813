#!/usr/bin/env python3
"""Brings a UR5e to its home pose."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]


class Arm:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction)
        self.client.wait_for_server()

    def home(self):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=HOME, velocities=[0.0] * 6, time_from_start=rospy.Duration(5.0)))
        self.client.send_goal_and_wait(goal)


def main():
    arm = Arm()
    rospy.init_node("ur5e_home")
    arm.home()
    rospy.loginfo("at home")


if __name__ == "__main__":
    main()
