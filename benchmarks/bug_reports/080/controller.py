#!/usr/bin/env python3
"""Plans a Panda to a list of joint values and executes the plan (Noetic)."""
import sys

import moveit_commander
import rospy

GOAL = [0.3, -0.6, 0.1, -2.2, 0.0, 1.7, 0.785]


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_plan_list")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)

    succeeded, plan, seconds, code = arm.plan(GOAL)
    if not succeeded:
        rospy.logerr("no plan: %d", code.val)
        sys.exit(1)
    rospy.loginfo("%d points", len(plan.joint_trajectory.points))
    executed = arm.execute(plan, wait=True)
    arm.stop()
    rospy.loginfo("executed: %s", executed)
    moveit_commander.roscpp_shutdown()


if __name__ == "__main__":
    main()
