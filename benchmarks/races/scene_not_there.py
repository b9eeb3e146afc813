"""Plans right after adding an obstacle, which move_group has not got yet.

Source: moveit/moveit issues 2623 and 38.
"""

import sys

import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("scene_not_there")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.5)
    arm.set_max_acceleration_scaling_factor(0.5)
    joints = [-0.7, 0.4, 0.0, -1.9, 0.0, 2.3, 0.8]
    arm.go(joints, wait=True)
    scene = moveit_commander.PlanningSceneInterface()
    wall = PoseStamped()
    wall.header.frame_id = "panda_link0"
    wall.pose.position.x, wall.pose.position.z = 0.6, 0.25
    wall.pose.orientation.w = 1.0
    scene.add_box("wall", wall, size=(0.4, 0.04, 0.5))
    joints[0] = 0.7
    arm.go(joints, wait=True)


if __name__ == "__main__":
    main()
