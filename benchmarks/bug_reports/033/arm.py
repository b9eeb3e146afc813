"""The arm of the cell, a UR5e."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


class Arm:
    def __init__(self):
        rospy.init_node("arm_client")
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction)
        self.client.wait_for_server()

    def go(self, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6, time_from_start=rospy.Duration(seconds)))
        self.client.send_goal_and_wait(goal)
        return self.client.get_result().error_code
