#!/usr/bin/env python3
"""Point a UR5e at what a tracker sees: always at the latest direction (ROS 1)."""
import sys
import threading

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
POSTURE = [0.0, -1.5, 1.6, -1.67, -1.57, 0.0]


class Follower:
    def __init__(self):
        self.moves = 0
        self.lock = threading.Lock()
        self.arm = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.arm.wait_for_server()
        self.point_at(0.0, 3.0)
        rospy.Subscriber("/tracker/direction", Float64, self.on_direction)

    def point_at(self, direction, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=[direction] + POSTURE[1:], velocities=[0.0] * 6,
            time_from_start=rospy.Duration(seconds))]
        return self.arm.send_goal_and_wait(goal)

    def on_direction(self, msg):
        """Two seconds for each turn; whatever came in between is old by then."""
        with self.lock:
            self.point_at(msg.data, 2.0)
            self.moves += 1
            rospy.loginfo("t=%.1f: pointed at %.2f", rospy.get_time(), msg.data)


def main():
    rospy.init_node("turn_follower")
    follower = Follower()
    rospy.sleep(40.0)
    rospy.loginfo("%d moves", follower.moves)
    return 0


if __name__ == "__main__":
    sys.exit(main())
