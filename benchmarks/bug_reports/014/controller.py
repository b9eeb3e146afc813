#!/usr/bin/env python3
"""Waves with an xArm 6 in Gazebo by the action of its trajectory controller."""
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

NAMES = ["link%d" % number for number in range(1, 7)]
WAVES = [[0.4, -0.3, -0.6, 0.0, 0.9, 0.0], [-0.4, -0.3, -0.6, 0.0, 0.9, 0.0]]


def main():
    rospy.init_node("xarm6_wave")
    client = actionlib.SimpleActionClient(
        "/xarm/xarm6_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()

    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = NAMES
    for number, positions in enumerate(WAVES, 1):
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6,
            time_from_start=rospy.Duration(3.0 * number)))
    state = client.send_goal_and_wait(goal)
    rospy.loginfo("the controller says %s", GoalStatus.to_string(state))
    result = client.get_result()
    if result:
        rospy.loginfo("error code %d %s", result.error_code, result.error_string)


if __name__ == "__main__":
    main()
