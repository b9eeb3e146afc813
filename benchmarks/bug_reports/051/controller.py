#!/usr/bin/env python3
"""Logs where the hand of a Panda is, and turns the base."""
import actionlib
import rospy
import transforms_helper
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

TURNED = [0.6, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


def main():
    rospy.init_node("panda_log_and_turn")
    client = actionlib.SimpleActionClient(
        "/position_joint_trajectory_controller/follow_joint_trajectory",
        FollowJointTrajectoryAction)
    client.wait_for_server()
    rospy.loginfo("hand at %s", transforms_helper.position("panda_link0", "panda_link8"))
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = ["panda_joint%d" % i for i in range(1, 8)]
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=TURNED, velocities=[0.0] * 7, time_from_start=rospy.Duration(4.0)))
    client.send_goal_and_wait(goal)
    rospy.loginfo("hand at %s", transforms_helper.position("panda_link0", "panda_link8"))


if __name__ == "__main__":
    main()
