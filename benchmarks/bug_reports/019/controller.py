#!/usr/bin/env python3
"""Approaches with a UR5 by URScript, then places by the trajectory controller (ur_modern_driver)."""
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
PLACE = [-0.5, -1.3, 1.6, -1.87, -1.57, 0.0]


def main():
    rospy.init_node("ur5_script_and_trajectory")
    script = rospy.Publisher("/ur_driver/URScript", String, queue_size=1)
    arm = actionlib.SimpleActionClient(
        "/pos_based_pos_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    arm.wait_for_server()
    rospy.sleep(1.0)

    script.publish("movej([0.3, -1.3, 1.6, -1.87, -1.57, 0.0], a=1.0, v=0.6)\n")
    rospy.sleep(6.0)
    rospy.loginfo("approached")

    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=PLACE, velocities=[0.0] * 6, time_from_start=rospy.Duration(4.0)))
    arm.send_goal(goal)
    arm.wait_for_result(rospy.Duration(10.0))
    if arm.get_state() == GoalStatus.SUCCEEDED:
        rospy.loginfo("placed")
    else:
        rospy.logerr("not placed: %s", GoalStatus.to_string(arm.get_state()))


if __name__ == "__main__":
    main()
