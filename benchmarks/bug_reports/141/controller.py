#!/usr/bin/env python3
"""A Panda takes a vial of 40 mm with franka_gripper, and lifts it; a failed grasp is tried again."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from franka_gripper.msg import GraspAction, GraspGoal, GraspResult, MoveAction, MoveGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
AT_VIAL = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
LIFTED = [0.0, -0.9, 0.0, -2.3, 0.0, 1.4, 0.785]
WIDTH = 0.040       # [m]
TRIES = 3


class Vial:
    def __init__(self):
        self.arm = actionlib.SimpleActionClient(
            "/position_joint_trajectory_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction)
        self.move_hand = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        self.grasp_hand = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
        for client in (self.arm, self.move_hand, self.grasp_hand):
            client.wait_for_server()

    def move(self, positions):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 7, time_from_start=rospy.Duration(3.0))]
        self.arm.send_goal_and_wait(goal)
        if self.arm.get_result().error_code != 0:
            raise RuntimeError(self.arm.get_result().error_string)

    def open(self):
        self.move_hand.send_goal_and_wait(MoveGoal(width=0.078, speed=0.05))

    def grasp(self):
        goal = GraspGoal()
        goal.width = WIDTH
        goal.epsilon.inner = 0.005
        goal.epsilon.outer = 0.005
        goal.speed = 0.03
        goal.force = 10.0
        result = GraspResult()
        self.grasp_hand.send_goal(goal)
        if not self.grasp_hand.wait_for_result(rospy.Duration(15.0)):
            rospy.logwarn("the grasp takes too long")
            self.grasp_hand.cancel_goal()
        rospy.loginfo("the grasp finished: %s", result.success)
        return result.success


def main():
    rospy.init_node("vial_lifter")
    vial = Vial()
    vial.open()
    vial.move(AT_VIAL)
    for number in range(1, TRIES + 1):
        if vial.grasp():
            break
        rospy.logwarn("try %d failed, opening again", number)
        vial.open()
    else:
        raise RuntimeError("the vial could not be grasped")
    vial.move(LIFTED)
    rospy.loginfo("the vial is lifted")


if __name__ == "__main__":
    main()
