#!/usr/bin/env python3
"""Tells MoveIt about a block by the topic /planning_scene and moves a Panda."""
import sys

import moveit_commander
import rospy
from geometry_msgs.msg import Pose
from moveit_msgs.msg import CollisionObject, PlanningScene
from shape_msgs.msg import SolidPrimitive


def block():
    item = CollisionObject()
    item.header.frame_id = "panda_link0"
    item.id = "block"
    item.primitives.append(SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.2, 0.2, 0.2]))
    pose = Pose()
    pose.position.x = 0.6
    pose.position.z = 0.1
    pose.orientation.w = 1.0
    item.primitive_poses.append(pose)
    item.operation = CollisionObject.ADD
    return item


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("panda_block")
    interface = moveit_commander.PlanningSceneInterface()
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(0.4)
    arm.set_max_acceleration_scaling_factor(0.4)

    publisher = rospy.Publisher("/planning_scene", PlanningScene, queue_size=1)
    scene = PlanningScene()
    scene.is_diff = True
    scene.robot_state.is_diff = True
    scene.world.collision_objects.append(block())
    publisher.publish(scene)

    rospy.sleep(1.0)
    known = interface.get_known_object_names()
    rospy.loginfo("known: %s", known)
    if "block" not in known:
        raise RuntimeError("MoveIt does not know the block")
    arm.go([0.5, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], wait=True)


if __name__ == "__main__":
    main()
