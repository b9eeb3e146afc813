#!/usr/bin/env python3
"""Show a part to a camera from three sides with a Panda and its trajectory controller."""
import sys

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
SIDES = [
    [0.3, -0.5, 0.0, -2.1, 0.0, 1.7, 0.785],
    [0.3, -0.5, 0.0, -2.1, 0.0, 1.7, 2.0],
    [0.3, -0.5, 0.0, -2.1, 0.0, 1.7, -0.4],
]
SECONDS_PER_SIDE = 2.5


def trajectory(stops):
    result = JointTrajectory()
    result.joint_names = JOINTS
    at = 0.0
    for stop in stops:
        at += SECONDS_PER_SIDE
        point = JointTrajectoryPoint()
        point.positions = stop
        point.velocities = [0.0] * len(JOINTS)
        point.time_from_start = at
        result.points.append(point)
    return result


def run(client, stops):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory = trajectory(stops)
    client.send_goal(goal)
    client.wait_for_result()
    return client.get_result().error_code


def main():
    rospy.init_node("panda_wave")
    client = actionlib.SimpleActionClient(
        "/position_joint_trajectory_controller/follow_joint_trajectory",
        FollowJointTrajectoryAction)
    client.wait_for_server()
    rospy.loginfo("ready: %d", run(client, [READY]))
    rospy.loginfo("sides: %d", run(client, SIDES))
    rospy.loginfo("back: %d", run(client, [READY]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
