#!/usr/bin/env python3
"""A UR5e serves three boxes of a feeder in turn. All goals are prepared when the cell starts."""
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
ABOVE = [-1.57, 1.57, -1.57, -1.57, 0.0]
BOXES = [("left", 0.5), ("middle", 0.0), ("right", -0.5)]
SECONDS = 3.0


def prepared(name, pan):
    """The goal for one box, ready to be sent."""
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.header.stamp = rospy.Time.now()
    goal.trajectory.header.frame_id = name
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [JointTrajectoryPoint(
        positions=[pan] + ABOVE, velocities=[0.0] * 6,
        time_from_start=rospy.Duration(SECONDS))]
    goal.goal_time_tolerance = rospy.Duration(1.0)
    return goal


class Feeder:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory",
            FollowJointTrajectoryAction)
        self.client.wait_for_server()
        self.goals = [(name, prepared(name, pan)) for name, pan in BOXES]
        self.served = []

    def serve(self, name, goal):
        self.client.send_goal(goal)
        self.client.wait_for_result()
        state = self.client.get_state()
        result = self.client.get_result()
        rospy.loginfo("box %s: state %d, error code %d %s",
                      name, state, result.error_code, result.error_string)
        if state != GoalStatus.SUCCEEDED:
            raise RuntimeError("box %s was not served" % name)
        self.served.append(name)
        rospy.sleep(0.5)      # the box is filled

    def run(self):
        for name, goal in self.goals:
            self.serve(name, goal)


def main():
    rospy.init_node("feeder_boxes")
    feeder = Feeder()
    feeder.run()
    rospy.loginfo("served: %s", ", ".join(feeder.served))


if __name__ == "__main__":
    main()
