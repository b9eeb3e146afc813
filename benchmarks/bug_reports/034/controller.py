#!/usr/bin/env python3
"""Lifts a cube with a Panda; the hand closes by the GripperCommand action of franka_gripper."""
import sys
from copy import deepcopy

import actionlib
import moveit_commander
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import GripperCommandAction, GripperCommandGoal
from franka_gripper.msg import MoveAction, MoveGoal
from geometry_msgs.msg import Pose

CUBE = (0.5, 0.0)
ABOVE = 0.3
AT = 0.1234  # panda_link8 is 0.1034 m above the finger tips


def pose_at(z):
    pose = Pose()
    pose.position.x, pose.position.y = CUBE
    pose.position.z = z
    pose.orientation.x = 0.9238795
    pose.orientation.y = -0.3826834
    return pose


class Picker:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_max_acceleration_scaling_factor(0.4)
        self.move = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        self.grasp = actionlib.SimpleActionClient("/franka_gripper/gripper_action", GripperCommandAction)
        self.move.wait_for_server()
        self.grasp.wait_for_server()

    def go(self, z):
        self.arm.set_pose_target(pose_at(z))
        if not self.arm.go(wait=True):
            raise RuntimeError("no way to z = %.2f" % z)
        self.arm.stop()
        self.arm.clear_pose_targets()

    def straight(self, z):
        target = deepcopy(self.arm.get_current_pose().pose)
        target.position.z = z
        plan, fraction = self.arm.compute_cartesian_path([target], 0.01)
        if fraction < 1.0:
            raise RuntimeError("only %.2f of the line" % fraction)
        plan = self.arm.retime_trajectory(self.arm.get_current_state(), plan, 0.3, 0.3)
        self.arm.execute(plan, wait=True)

    def open(self):
        self.move.send_goal_and_wait(MoveGoal(width=0.08, speed=0.1))

    def close(self):
        goal = GripperCommandGoal()
        goal.command.position = 0.0
        goal.command.max_effort = 20.0
        state = self.grasp.send_goal_and_wait(goal, rospy.Duration(10.0))
        if state != GoalStatus.SUCCEEDED:
            raise RuntimeError("the hand did not close on the cube: %s"
                               % GoalStatus.to_string(state))


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_pick_cube")
    picker = Picker()
    picker.open()
    picker.go(ABOVE)
    picker.straight(AT)
    picker.close()
    picker.straight(ABOVE)
    rospy.loginfo("lifted")


if __name__ == "__main__":
    main()
