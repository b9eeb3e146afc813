#!/usr/bin/env python3
"""Moves the wrist of a UR5e through a row of quick, small nods."""
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
STEP = 0.5


def nods(start):
    """The points of the nods, STEP seconds apart, after four seconds to get to the first."""
    seconds = 4.0
    for number in range(8):
        positions = list(start)
        positions[3] += 0.1 if number % 2 else -0.1
        point = JointTrajectoryPoint()
        point.positions = positions
        point.time_from_start = rospy.Duration(int(seconds))
        yield point
        seconds += STEP


def main():
    rospy.init_node("ur5e_nod")
    client = actionlib.SimpleActionClient(
        "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = list(nods([0.0, -1.2, 1.6, -1.97, -1.57, 0.0]))
    state = client.send_goal_and_wait(goal)
    if state != GoalStatus.SUCCEEDED:
        result = client.get_result()
        rospy.logerr("%s: %s %s", GoalStatus.to_string(state),
                     result.error_code if result else "", result.error_string if result else "")
    else:
        rospy.loginfo("nodded")


if __name__ == "__main__":
    main()
