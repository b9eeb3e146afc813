#!/usr/bin/env python3
"""A UR5e whose home position is a service; the program homes it and turns it then."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.5, 1.6, -1.67, -1.57, 0.0]
TURNED = [0.7, -1.5, 1.6, -1.67, -1.57, 0.0]


class Arm:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction)
        self.client.wait_for_server()
        rospy.Service("/arm/home", Trigger, self.on_home)

    def go(self, positions):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(5.0)))
        self.client.send_goal_and_wait(goal)

    def on_home(self, request):
        rospy.loginfo("homing")
        self.go(HOME)


def main():
    rospy.init_node("ur5e_home_service")
    arm = Arm()
    rospy.wait_for_service("/arm/home")
    home = rospy.ServiceProxy("/arm/home", Trigger)
    answer = home()
    rospy.loginfo("homed: %s", answer.success)
    arm.go(TURNED)
    rospy.loginfo("turned")


if __name__ == "__main__":
    main()
