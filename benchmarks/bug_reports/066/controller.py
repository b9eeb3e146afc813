#!/usr/bin/env python3
"""Turns the base of a Panda from wherever it stands; every other joint keeps its position."""
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint


def main():
    rospy.init_node("panda_turn_base")
    client = actionlib.SimpleActionClient(
        "/position_joint_trajectory_controller/follow_joint_trajectory",
        FollowJointTrajectoryAction)
    client.wait_for_server()

    state = rospy.wait_for_message("/joint_states", JointState)
    target = dict(zip(state.name, state.position))
    if "panda_finger_joint1" not in target:
        raise RuntimeError("the hand is not connected")
    target["panda_joint1"] = 0.5

    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = list(target)
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=list(target.values()), velocities=[0.0] * len(target),
        time_from_start=rospy.Duration(4.0)))
    state = client.send_goal_and_wait(goal)
    result = client.get_result()
    rospy.loginfo("%s, error code %s", GoalStatus.to_string(state),
                  result.error_code if result else None)


if __name__ == "__main__":
    main()
