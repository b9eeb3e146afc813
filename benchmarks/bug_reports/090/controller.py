#!/usr/bin/env python3
"""Turns the last two joints of a UR5e in Gazebo; its controller allows partial goals."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint


def main():
    rospy.init_node("ur5e_wrist")
    client = actionlib.SimpleActionClient(
        "/pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = ["wrist_2_joint", "wrist_3_joint"]
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=[-1.2, 0.5], velocities=[0.0, 0.0], time_from_start=rospy.Duration(4.0)))
    client.send_goal_and_wait(goal)
    code = client.get_result().error_code
    if code != 0:
        raise RuntimeError("error code %d" % code)
    rospy.loginfo("turned")


if __name__ == "__main__":
    main()
