#!/usr/bin/env python3
"""Point at a part with a Panda: a camera above the table sees it, tf tells where the camera is."""
import sys

import moveit_commander
import numpy as np
import rospy
import tf
from tf import transformations

BASE = "panda_link0"
CAMERA = "camera_optical"
TIP = "panda_link8"
# what the camera measures, in its own axes: x right, y up the table, z away from it [m]
PARTS = [("nut", (0.0, 0.30, 0.55))]


class Pointer:
    def __init__(self):
        self.listener = tf.TransformListener()
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_max_acceleration_scaling_factor(0.4)
        self.arm.set_pose_reference_frame(BASE)
        self.arm.set_planning_time(5.0)

    def ready(self):
        self.arm.set_named_target("ready")
        if not self.arm.go(wait=True):
            raise RuntimeError("the ready pose was not reached")
        self.arm.stop()

    def camera_to_base(self):
        """The matrix that takes points of the camera to points of the base."""
        self.listener.waitForTransform(CAMERA, BASE, rospy.Time(0), rospy.Duration(4.0))
        trans, rot = self.listener.lookupTransform(CAMERA, BASE, rospy.Time(0))
        matrix = transformations.quaternion_matrix(rot)
        matrix[:3, 3] = trans
        return matrix

    def in_base(self, point):
        homogeneous = np.array([point[0], point[1], point[2], 1.0])
        return self.camera_to_base().dot(homogeneous)[:3]

    def point_at(self, name, seen):
        where = self.in_base(seen)
        rospy.loginfo("%s: seen at %s, that is %s in the base",
                      name, np.round(seen, 3).tolist(), np.round(where, 3).tolist())
        self.arm.set_position_target(where.tolist(), TIP)
        reached = self.arm.go(wait=True)
        self.arm.stop()
        self.arm.clear_pose_targets()
        if not reached:
            raise RuntimeError("%s is out of reach" % name)
        now = self.arm.get_current_pose(TIP).pose.position
        rospy.loginfo("%s: the tip is at %.3f %.3f %.3f", name, now.x, now.y, now.z)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("point_at_parts")
    pointer = Pointer()
    pointer.ready()
    for name, seen in PARTS:
        pointer.point_at(name, seen)
    rospy.loginfo("pointed at all parts")


if __name__ == "__main__":
    main()
