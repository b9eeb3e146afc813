"""Try the hinges of two doors with a six-axis arm (ROS 1, actionlib)."""

import sys

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["axis_1", "axis_2", "axis_3", "axis_4", "axis_5", "axis_6"]
HOME = [0.0, -0.3, 1.2, 0.6, 0.0, 0.2]
LEFT_DOOR = [1.0, 0.5, 0.9, 0.4, 0.3, 0.4]
RIGHT_DOOR = [-1.0, 0.5, 0.9, 0.4, -0.3, 0.4]


class DoorCheck:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/arm_controller/follow_joint_trajectory", FollowJointTrajectoryAction
        )
        if not self.client.wait_for_server(rospy.Duration(5.0)):
            raise rospy.ROSException("no controller")

    def drive(self, posture, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint()
        point.positions = posture
        point.time_from_start = rospy.Duration(seconds)
        goal.trajectory.points.append(point)
        self.client.send_goal(goal)
        self.client.wait_for_result()
        result = self.client.get_result()
        if result is None or result.error_code != 0:
            rospy.logerr("the controller answered %s", result)
            return False
        return True

    def push(self, door):
        if not self.drive(door, 2.0):
            return False
        pushed = list(door)
        pushed[3] += 0.3
        return self.drive(pushed, 1.0) and self.drive(door, 1.0)

    def go_home(self):
        return self.drive(HOME, 2.0)


def main():
    rospy.init_node("door_check")
    check = DoorCheck()
    check.go_home()
    for door in (LEFT_DOOR, RIGHT_DOOR):
        if not check.push(door):
            return 1
    check.go_home()
    return 0


if __name__ == "__main__":
    sys.exit(main())
