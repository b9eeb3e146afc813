#!/usr/bin/env python3
"""Reaches forward with a Hello Robot Stretch (stretch_driver)."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint


def main():
    rospy.init_node("stretch_reach")
    mode = rospy.ServiceProxy("/switch_to_position_mode", Trigger)
    mode.wait_for_service()
    mode()
    client = actionlib.SimpleActionClient(
        "/stretch_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = ["joint_lift", "joint_arm"]
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=[0.7, 0.2], time_from_start=rospy.Duration(0.0)))
    client.send_goal(goal)
    client.wait_for_result()
    code = client.get_result().error_code
    if code != 0:
        raise RuntimeError("error code %d" % code)
    rospy.loginfo("reached")


if __name__ == "__main__":
    main()
