#!/usr/bin/env python3
# /// script
# [tool.tracerisk]
# scene = "tube_racks"
# ///
"""Take tubes out of a rack with a Franka Emika Panda, trying again when a grasp fails (ROS 1)."""

import sys

import actionlib
import moveit_commander
import rospy
from franka_gripper.msg import GraspAction, GraspEpsilon, GraspGoal, MoveAction, MoveGoal
from geometry_msgs.msg import Pose

RACK_Y = 0.20
FIRST_TUBE_X = 0.30
PITCH = 0.04
ABOVE = 0.3384  # of panda_link8, to clear the tubes
AT_TUBE = 0.1884

TUBE_WIDTH = 0.016
ATTEMPTS = 3


class GraspError(Exception):
    """The fingers closed, but on nothing."""


class TubePicker:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_max_acceleration_scaling_factor(0.4)
        self.move_client = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        self.grasp_client = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
        for client in (self.move_client, self.grasp_client):
            if not client.wait_for_server(rospy.Duration(10.0)):
                raise rospy.ROSException("no action server for the gripper")

    def pick(self, number):
        """Pick a tube up, in as many attempts as allowed; tell whether it worked."""
        for attempt in range(1, ATTEMPTS + 1):
            try:
                self.approach(number)
                self.grasp()
            except GraspError:
                rospy.logwarn("attempt %d of %d to take tube %d failed", attempt, ATTEMPTS, number)
                self.back_off()
            else:
                self.lift()
                return True
        return False

    def approach(self, number):
        """Open the hand, and let it down over the tube."""
        self.open_hand()
        pose = Pose()
        pose.position.x = FIRST_TUBE_X + PITCH * number
        pose.position.y = RACK_Y
        pose.position.z = ABOVE
        pose.orientation.x = 0.9238795
        pose.orientation.y = -0.3826834
        self.arm.set_pose_target(pose)
        self.arm.go(wait=True)
        self.arm.clear_pose_targets()
        self.straight_to(AT_TUBE)

    def grasp(self):
        """Close the fingers on the tube."""
        goal = GraspGoal(
            width=TUBE_WIDTH, speed=0.05, force=15.0, epsilon=GraspEpsilon(inner=0.004, outer=0.004)
        )
        self.grasp_client.send_goal_and_wait(goal, rospy.Duration(5.0))
        result = self.grasp_client.get_result()
        if result is None or not result.success:
            raise GraspError()

    def lift(self):
        """Draw the tube out of the rack."""
        self.straight_to(ABOVE)

    def put_back(self):
        """Let the tube down where it came from."""
        self.straight_to(AT_TUBE + 0.002)
        self.open_hand()
        self.straight_to(ABOVE)

    def back_off(self):
        """Leave the rack before the next attempt."""
        self.open_hand()
        self.straight_to(ABOVE)

    def ask_for_help(self):
        """Park the arm, so that somebody can look after the rack."""
        self.arm.set_named_target("ready")
        self.arm.go(wait=True)
        rospy.logerr("the rack needs attention")

    def open_hand(self):
        self.move_client.send_goal_and_wait(MoveGoal(width=0.07, speed=0.1), rospy.Duration(5.0))

    def straight_to(self, height):
        pose = self.arm.get_current_pose().pose
        pose.position.z = height
        plan, fraction = self.arm.compute_cartesian_path([pose], 0.01)
        if fraction < 1.0:
            raise RuntimeError("the way up or down is blocked")
        plan = self.arm.retime_trajectory(self.arm.get_current_state(), plan, 0.4, 0.4)
        self.arm.execute(plan, wait=True)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("careful_pick")
    picker = TubePicker()
    for number in (0, 2):
        if not picker.pick(number):
            picker.ask_for_help()
            return 1
        rospy.sleep(0.5)  # weigh the tube
        picker.put_back()
    return 0


if __name__ == "__main__":
    sys.exit(main())
