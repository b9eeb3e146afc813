#!/usr/bin/env python3
"""Shows how long a motion of a Panda takes, asks nothing, and goes."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_plan_then_go")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)
    arm.set_named_target("ready")
    arm.go(wait=True)
    arm.stop()

    pose = Pose()
    pose.position.x = 0.45
    pose.position.y = 0.2
    pose.position.z = 0.45
    pose.orientation.x = 0.9238795
    pose.orientation.y = -0.3826834
    arm.set_pose_target(pose)
    success, plan, _, _ = arm.plan()
    if not success:
        raise RuntimeError("no plan")
    last = plan.joint_trajectory.points[-1]
    rospy.loginfo("the motion takes about %.1f s", last.time_from_start.to_sec())
    rospy.loginfo("went: %s", arm.go(wait=True))
    arm.stop()
    arm.clear_pose_targets()


if __name__ == "__main__":
    main()
