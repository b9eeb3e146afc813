#!/usr/bin/env python3
"""Plans the way back of a Panda in advance, from where it is going to be, and drives it."""
import sys

import moveit_commander
import rospy
from moveit_msgs.msg import RobotState

OUT = [0.7, -0.6, 0.0, -2.2, 0.0, 1.6, 0.785]
BACK = [-0.7, -0.6, 0.0, -2.2, 0.0, 1.6, 0.785]


def state_at(arm, positions):
    state = RobotState()
    state.joint_state.name = arm.get_active_joints()
    state.joint_state.position = positions
    state.is_diff = True
    return state


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_ahead")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)
    arm.stop()

    arm.set_start_state(state_at(arm, OUT))
    success, plan, _, _ = arm.plan(BACK)
    if not success:
        raise RuntimeError("no way back")
    rospy.loginfo("planned from joint 1 at %.2f", plan.joint_trajectory.points[0].positions[0])
    rospy.loginfo("executed: %s", arm.execute(plan, wait=True))


if __name__ == "__main__":
    main()
