#!/usr/bin/env python3
"""Load a lathe with a UR5e; the program on the pendant is stopped while the operator is near."""
import sys

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
CONTROLLER = "/scaled_pos_joint_traj_controller/follow_joint_trajectory"
DASHBOARD = "/ur_hardware_interface/dashboard/"

WAITING = [0.0, -1.8, 1.8, -1.57, -1.57, 0.0]
AT_DOOR = [0.9, -1.4, 1.6, -1.77, -1.57, 0.0]
IN_LATHE = [1.2, -1.1, 1.4, -1.87, -1.57, 0.0]


class Loading:
    def __init__(self):
        self.arm = actionlib.SimpleActionClient(CONTROLLER, FollowJointTrajectoryAction)
        if not self.arm.wait_for_server(rospy.Duration(10.0)):
            raise rospy.ROSException("the controller is not there")

    def dashboard(self, command):
        name = DASHBOARD + command
        rospy.wait_for_service(name, 5.0)
        answer = rospy.ServiceProxy(name, Trigger)()
        rospy.loginfo("dashboard %s: %s", command, answer.success)
        return answer.success

    def go(self, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * 6,
            time_from_start=rospy.Duration(seconds))]
        state = self.arm.send_goal_and_wait(goal, rospy.Duration(seconds + 10.0))
        rospy.loginfo("goal ended in state %d", state)

    def operator_at_the_table(self):
        """The arm has to be still while somebody lays a part down."""
        self.dashboard("stop")
        rospy.sleep(4.0)
        rospy.loginfo("the part lies on the table")


def main():
    rospy.init_node("ur_loading")
    cell = Loading()
    cell.go(WAITING, 4.0)
    cell.operator_at_the_table()
    cell.go(AT_DOOR, 4.0)
    cell.go(IN_LATHE, 3.0)
    cell.go(WAITING, 5.0)
    rospy.loginfo("the lathe is loaded")
    return 0


if __name__ == "__main__":
    sys.exit(main())
