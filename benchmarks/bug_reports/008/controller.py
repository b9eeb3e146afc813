#!/usr/bin/env python3
"""Logs where the tool of a UR5e is in its first pose, and goes to the second."""
import actionlib
import rospy
import tf
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
FIRST = [0.0, -1.5, 1.6, -1.67, -1.57, 0.0]
SECOND = [0.6, -1.5, 1.6, -1.67, -1.57, 0.0]


def go(client, positions):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(5.0)))
    client.send_goal_and_wait(goal)


def main():
    rospy.init_node("ur5e_two_poses")
    listener = tf.TransformListener()
    client = actionlib.SimpleActionClient(
        "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()
    go(client, FIRST)
    (translation, rotation) = listener.waitForTransform(
        "base_link", "tool0", rospy.Time(0), rospy.Duration(3.0))
    rospy.loginfo("tool at %s", translation)
    go(client, SECOND)


if __name__ == "__main__":
    main()
