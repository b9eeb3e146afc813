#!/usr/bin/env python3
"""Sends a UR5e from where it is through a point to a pose."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
VIA = [0.2, -1.5, 1.6, -1.67, -1.57, 0.0]
POSE = [0.5, -1.3, 1.6, -1.87, -1.57, 0.0]


def point(positions, seconds):
    return JointTrajectoryPoint(
        positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(seconds))


def main():
    rospy.init_node("ur5e_via_point")
    client = actionlib.SimpleActionClient(
        "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    client.wait_for_server()
    state = rospy.wait_for_message("/joint_states", JointState)
    here = dict(zip(state.name, state.position))

    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [
        point([here[name] for name in JOINTS], 0.0), point(VIA, 5.0), point(POSE, 8.0)]
    client.send_goal_and_wait(goal)
    code = client.get_result().error_code
    if code != 0:
        raise RuntimeError("error code %d" % code)
    rospy.loginfo("arrived")


if __name__ == "__main__":
    main()
