"""Looks a frame up right after creating the listener, without a timeout.

Source: ros2/geometry2 issue 373.
"""

import sys

import moveit_commander
import rospy
import tf2_ros


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("frame_at_once")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer)
    rospy.sleep(0.1)
    height = 0.4
    try:
        lookup_transform = buffer.lookup_transform("panda_link0", "panda_hand", rospy.Time(0))
        height = lookup_transform.transform.translation.z
    except tf2_ros.LookupException:
        rospy.logwarn("no frame, using a height of %.1f m", height)
    pose = arm.get_current_pose().pose
    pose.position.z = height - 0.1
    arm.set_pose_target(pose)
    arm.go(wait=True)


if __name__ == "__main__":
    main()
