#!/usr/bin/env python3
"""Turns the base of a UR10e a little and leaves the other joints as they are."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.3, 1.5, -1.87, -1.57, 0.0]


class Arm:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction)
        self.client.wait_for_server()

    def go(self, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6,
            time_from_start=rospy.Duration(seconds)))
        self.client.send_goal_and_wait(goal)
        return self.client.get_result().error_code

    def turn_base(self, angle):
        state = rospy.wait_for_message("/joint_states", JointState)
        positions = list(state.position)
        positions[0] += angle
        return self.go(positions, 6.0)


def main():
    rospy.init_node("ur10e_turn_base")
    arm = Arm()
    rospy.loginfo("home: %d", arm.go(HOME, 5.0))
    rospy.sleep(0.5)
    rospy.loginfo("turned: %d", arm.turn_base(0.3))


if __name__ == "__main__":
    main()
