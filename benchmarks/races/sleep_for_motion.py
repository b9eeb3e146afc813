"""Sleeps as long as its motion took in the simulation, in the place of waiting for its end.

Source: ROBOTIS-GIT/turtlebot3 issue 746.
"""

import sys

import moveit_commander
import rospy


def go(arm, turn, seconds):
    joints = arm.get_current_joint_values()
    joints[0] = turn
    arm.set_joint_value_target(joints)
    arm.go(wait=False)
    rospy.sleep(seconds)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("sleep_for_motion")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)
    go(arm, 0.6, 2.0)
    go(arm, -0.6, 2.5)
    go(arm, 0.0, 2.0)


if __name__ == "__main__":
    main()
