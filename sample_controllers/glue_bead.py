#!/usr/bin/env python
# Lay a bead of glue along the rim of a housing with a Lite 6 and MoveIt (ROS 1).
import copy
import sys

import moveit_commander
import rospy

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("glue_bead")

arm = moveit_commander.MoveGroupCommander("lite6")
arm.set_max_velocity_scaling_factor(0.3)
arm.set_max_acceleration_scaling_factor(0.3)

length = rospy.get_param("~length", 0.12)  # of the housing, along y [m]
width = rospy.get_param("~width", 0.08)  # along x [m]
beads = rospy.get_param("~beads", 2)

# Above the first corner, nozzle down.
approach = [-0.4, 0.35, 1.35, 0.0, 1.0, -0.4]
arm.go(approach, wait=True)
arm.stop()

corner = arm.get_current_pose().pose
rospy.loginfo("first corner at x %.3f, y %.3f", corner.position.x, corner.position.y)

for bead in range(beads):
    # Down to the rim, around it, and up again.
    waypoints = []
    pose = copy.deepcopy(corner)
    pose.position.z -= 0.05
    waypoints.append(copy.deepcopy(pose))
    pose.position.y += length
    waypoints.append(copy.deepcopy(pose))
    pose.position.x += width
    waypoints.append(copy.deepcopy(pose))
    pose.position.y -= length
    waypoints.append(copy.deepcopy(pose))
    pose.position.x -= width
    waypoints.append(copy.deepcopy(pose))
    pose.position.z += 0.05
    waypoints.append(copy.deepcopy(pose))

    plan, fraction = arm.compute_cartesian_path(waypoints, 0.005)
    if fraction < 0.99:
        rospy.logerr("only %.0f %% of the rim can be reached", 100 * fraction)
        sys.exit(1)
    arm.execute(plan, wait=True)
    rospy.loginfo("bead %d of %d is laid", bead + 1, beads)
    rospy.sleep(1.0)

arm.set_named_target("home")
arm.go(wait=True)
arm.stop()
moveit_commander.roscpp_shutdown()
