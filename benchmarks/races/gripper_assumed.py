"""Goes into the part without opening the gripper: it is open in the simulation.

Source: pharmbio/robotlab issue 2 (a program that crashes if the gripper is closed at the start).
"""

import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose

OVER, AT = 0.34, 0.19


def pose(height):
    target = Pose()
    target.position.x, target.position.y, target.position.z = 0.42, 0.2, height
    target.orientation.x, target.orientation.y = 0.9238795, -0.3826834
    return target


def take(arm, hand):
    arm.set_pose_target(pose(OVER))
    arm.go(wait=True)
    path, _ = arm.compute_cartesian_path([pose(AT)], 0.01)
    arm.execute(path, wait=True)
    hand.set_named_target("close")
    hand.go(wait=True)
    path, _ = arm.compute_cartesian_path([pose(OVER)], 0.01)
    arm.execute(path, wait=True)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("gripper_assumed")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    hand = moveit_commander.MoveGroupCommander("hand")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)
    take(arm, hand)


if __name__ == "__main__":
    main()
