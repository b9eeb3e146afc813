#!/usr/bin/env python3
"""Approaches with a UR5e by URScript, restarts external control, and places by a trajectory."""
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_msgs.msg import String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
PLACE = [-0.5, -1.3, 1.6, -1.87, -1.57, 0.0]


def main():
    rospy.init_node("ur5e_script_and_trajectory")
    script = rospy.Publisher("/ur_hardware_interface/script_command", String, queue_size=1)
    play = rospy.ServiceProxy("/ur_hardware_interface/dashboard/play", Trigger)
    play.wait_for_service()
    arm = actionlib.SimpleActionClient(
        "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
    arm.wait_for_server()
    while script.get_num_connections() == 0:
        rospy.sleep(0.1)

    script.publish("movej([0.3, -1.3, 1.6, -1.87, -1.57, 0.0], a=1.0, v=0.6)\n")
    rospy.sleep(6.0)

    answer = play()
    if not answer.success:
        raise RuntimeError(answer.message)
    rospy.sleep(2.0)

    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points.append(JointTrajectoryPoint(
        positions=PLACE, velocities=[0.0] * 6, time_from_start=rospy.Duration(4.0)))
    state = arm.send_goal_and_wait(goal, rospy.Duration(15.0))
    if state != GoalStatus.SUCCEEDED:
        raise RuntimeError(GoalStatus.to_string(state))
    rospy.loginfo("placed")


if __name__ == "__main__":
    main()
