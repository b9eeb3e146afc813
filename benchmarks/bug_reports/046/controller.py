#!/usr/bin/env python3
"""Lifts a cube from a stand with a UR5e in Gazebo; the cube is attached to its flange."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from gazebo_ros_link_attacher.srv import Attach, AttachRequest
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HIGH = [0.0, -1.6, 1.5, -1.47, -1.57, 0.0]
LOW = [0.0, -1.3, 1.5, -1.77, -1.57, 0.0]


class Lifter:
    def __init__(self):
        self.arm = actionlib.SimpleActionClient(
            "/pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.arm.wait_for_server()
        self.attach = rospy.ServiceProxy("/link_attacher_node/attach", Attach)
        self.attach.wait_for_service()

    def go(self, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(seconds)))
        self.arm.send_goal_and_wait(goal)
        if self.arm.get_result().error_code != 0:
            raise RuntimeError("the arm did not arrive")

    def take(self):
        request = AttachRequest()
        request.model_name_1 = "robot"
        request.link_name_1 = "wrist_3_link"
        request.model_name_2 = "cube"
        request.link_name_2 = "link"
        if not self.attach(request).ok:
            raise RuntimeError("not attached")


def main():
    rospy.init_node("ur5e_lift_cube")
    lifter = Lifter()
    lifter.go(HIGH, 5.0)
    lifter.go(LOW, 3.0)
    lifter.take()
    lifter.go(HIGH, 3.0)
    rospy.loginfo("lifted")


if __name__ == "__main__":
    main()
