#!/usr/bin/env python3
"""An arm (an xArm 6 here) taps three times with its last joints, whatever the maker calls its joints."""
import actionlib
import rospy
from control_msgs.msg import (
    FollowJointTrajectoryAction, FollowJointTrajectoryGoal, FollowJointTrajectoryResult)
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

ACTION = "/xarm/xarm6_traj_controller/follow_joint_trajectory"
PREFIX = "joint_"       # the gripper's joints have other names
TAP = 0.15              # [rad]


class Tapper:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
        self.client.wait_for_server()
        self.names = []
        self.begin = []

    def learn(self):
        """Which joints the arm has, and where they are."""
        state = rospy.wait_for_message("/joint_states", JointState, timeout=5.0)
        for name, position in sorted(zip(state.name, state.position)):
            if name.startswith(PREFIX):
                self.names.append(name)
                self.begin.append(position)
        rospy.loginfo("%d of %d joints belong to the arm", len(self.names), len(state.name))

    def tapped(self, angle):
        """The positions of a tap: the last but one joint turned by the angle."""
        return [position + (angle if index == len(self.begin) - 2 else 0.0)
                for index, position in enumerate(self.begin)]

    def move(self, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = self.names
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=positions, velocities=[0.0] * len(positions),
            time_from_start=rospy.Duration(seconds))]
        self.client.send_goal(goal)
        self.client.wait_for_result(rospy.Duration(seconds + 5.0))
        result = self.client.get_result()
        if result is None or result.error_code != FollowJointTrajectoryResult.SUCCESSFUL:
            code = None if result is None else result.error_code
            raise RuntimeError("the arm did not move: error code %s, %s"
                               % (code, self.client.get_goal_status_text()))


def main():
    rospy.init_node("tapper")
    tapper = Tapper()
    tapper.learn()
    for number in (1, 2, 3):
        tapper.move(tapper.tapped(TAP), 1.0)
        tapper.move(tapper.tapped(0.0), 1.0)
        rospy.loginfo("tap %d", number)
    rospy.loginfo("tapped")


if __name__ == "__main__":
    main()
