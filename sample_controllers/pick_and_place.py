#!/usr/bin/env python3
# /// script
# [tool.tracerisk]
# scene = "tube_racks"
# ///
"""Move ten test tubes from one rack to another with a Franka Emika Panda."""

import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose

# The racks stand left and right of the robot's base; both have ten slots in a row along x.
FIRST_SLOT_X = 0.30
SLOT_PITCH = 0.04
SOURCE_RACK_Y = 0.20
TARGET_RACK_Y = -0.20
TUBES = 10

# Heights of panda_link8, which is 0.1034 m above the point between the finger tips.
TRAVEL_HEIGHT = 0.3384
GRASP_HEIGHT = 0.1884
RELEASE_HEIGHT = 0.1904

EEF_STEP = 0.01


def slot(number, rack_y, height):
    """The pose above a slot of a rack, with the hand pointing down."""
    pose = Pose()
    pose.position.x = FIRST_SLOT_X + SLOT_PITCH * number
    pose.position.y = rack_y
    pose.position.z = height
    pose.orientation.x = 0.9238795
    pose.orientation.y = -0.3826834
    return pose


def straight_to(arm, height):
    """Move the hand straight up or down."""
    target = arm.get_current_pose().pose
    target.position.z = height
    plan, fraction = arm.compute_cartesian_path([target], EEF_STEP)
    if fraction < 1.0:
        raise RuntimeError("only %.0f %% of the straight path can be followed" % (100 * fraction))
    plan = arm.retime_trajectory(arm.get_current_state(), plan, 0.5, 0.5)
    return arm.execute(plan, wait=True)


def init(arm, hand):
    """Go to the ready pose with an open gripper."""
    arm.set_named_target("ready")
    arm.go(wait=True)
    hand.set_named_target("open")
    hand.go(wait=True)


def pick_position(arm, number):
    """Go above the tube."""
    arm.set_pose_target(slot(number, SOURCE_RACK_Y, TRAVEL_HEIGHT))
    arm.go(wait=True)
    arm.stop()
    arm.clear_pose_targets()


def pick(arm, hand):
    """Take the tube out of the rack."""
    straight_to(arm, GRASP_HEIGHT)
    hand.set_named_target("close")
    hand.go(wait=True)
    straight_to(arm, TRAVEL_HEIGHT)


def place_position(arm, number):
    """Carry the tube to its slot and let it down."""
    arm.set_pose_target(slot(number, TARGET_RACK_Y, TRAVEL_HEIGHT))
    arm.go(wait=True)
    arm.stop()
    arm.clear_pose_targets()
    straight_to(arm, RELEASE_HEIGHT)


def place(hand):
    """Let go of the tube."""
    hand.set_named_target("open")
    hand.go(wait=True)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("pick_and_place")

    arm = moveit_commander.MoveGroupCommander("panda_arm")
    hand = moveit_commander.MoveGroupCommander("hand")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)

    for number in range(TUBES):
        init(arm, hand)
        pick_position(arm, number)
        pick(arm, hand)
        place_position(arm, number)
        place(hand)
        rospy.loginfo("tube %d of %d is in its rack", number + 1, TUBES)

    moveit_commander.roscpp_shutdown()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass
