#!/usr/bin/env python3
"""Brings a UR5e to its inspection pose."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
INSPECT = [-0.4, -1.4, 1.7, -1.87, -1.57, 0.0]


def goal_at(positions, seconds):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(seconds)))
    return goal


def main():
    rospy.init_node("ur5e_inspect")
    goal = goal_at(INSPECT, 5.0)
    client = actionlib.SimpleActionClient(
        "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.send_goal(goal)
    if client.wait_for_result(rospy.Duration(12.0)):
        rospy.loginfo("there, error code %d", client.get_result().error_code)
    else:
        rospy.logwarn("no result")


if __name__ == "__main__":
    main()
