#!/usr/bin/env python3
"""Opens the hand of a Panda and turns the arm aside."""
import actionlib
import franka_gripper.msg
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

ASIDE = [0.8, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


def open_hand(publisher):
    goal = franka_gripper.msg.MoveGoal(width=0.08, speed=0.1)
    publisher.publish(goal)
    rospy.sleep(2.0)
    rospy.loginfo("opened")


def main():
    rospy.init_node("panda_open_and_aside")
    publisher = rospy.Publisher(
        "/franka_gripper/move/goal", franka_gripper.msg.MoveActionGoal, queue_size=10)
    arm = actionlib.SimpleActionClient(
        "/position_joint_trajectory_controller/follow_joint_trajectory",
        FollowJointTrajectoryAction)
    arm.wait_for_server()
    open_hand(publisher)
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = ["panda_joint%d" % i for i in range(1, 8)]
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=ASIDE, velocities=[0.0] * 7, time_from_start=rospy.Duration(4.0)))
    arm.send_goal_and_wait(goal)
    rospy.loginfo("aside")


if __name__ == "__main__":
    main()
