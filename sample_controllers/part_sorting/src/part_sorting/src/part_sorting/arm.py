"""The WidowX 250 S as this package uses it: whole poses of the arm, and an open or closed hand."""

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

ARM_JOINTS = ["waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate"]
FINGERS = ["left_finger", "right_finger"]

# Joints after the waist.
CARRY = [-0.6, 0.4, 0.0, 0.9, 0.0]
REACH_DOWN = [0.35, 0.25, 0.0, 0.95, 0.0]


class Arm:
    """Arm and hand of one robot, each behind a trajectory controller."""

    def __init__(self, robot_name):
        self._arm = self._connect("/%s/arm_controller" % robot_name)
        self._hand = self._connect("/%s/gripper_controller" % robot_name)

    @staticmethod
    def _connect(controller):
        client = actionlib.SimpleActionClient(
            controller + "/follow_joint_trajectory", FollowJointTrajectoryAction
        )
        if not client.wait_for_server(rospy.Duration(5.0)):
            raise rospy.ROSException("%s is not running" % controller)
        return client

    def carry_to(self, bearing, seconds=2.0):
        """Turn to a bearing [rad] with the hand raised."""
        self._follow(self._arm, ARM_JOINTS, [bearing, *CARRY], seconds)

    def reach_down(self, bearing, seconds=1.5):
        """Let the hand down at a bearing [rad]."""
        self._follow(self._arm, ARM_JOINTS, [bearing, *REACH_DOWN], seconds)

    def open_hand(self):
        self._follow(self._hand, FINGERS, [0.037, -0.037], 0.5)

    def close_hand(self):
        self._follow(self._hand, FINGERS, [0.016, -0.016], 0.5)

    def _follow(self, client, joints, positions, seconds):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = joints
        goal.trajectory.points.append(
            JointTrajectoryPoint(
                positions=positions, time_from_start=rospy.Duration.from_sec(seconds)
            )
        )
        client.send_goal(goal)
        client.wait_for_result()
        result = client.get_result()
        if result.error_code != result.SUCCESSFUL:
            raise rospy.ROSException("the trajectory was not followed: " + result.error_string)
