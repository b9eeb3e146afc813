#!/usr/bin/env python
# Carries steel plates from the rack to the welding jig with a magnet. UR5e, ROS 1, no MoveIt commander:
# joint values by /compute_ik, trajectories by the driver's action.
import math

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from geometry_msgs.msg import PoseStamped
from moveit_msgs.srv import GetPositionIK, GetPositionIKRequest
from sensor_msgs.msg import JointState
from std_msgs.msg import Int16, String
from tf.transformations import quaternion_from_euler
from trajectory_msgs.msg import JointTrajectoryPoint

from tools import Magnet

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
READY = [0.0, -1.35, 1.75, -1.97, -1.57, 0.0]

PLATE = 0.016          # thickness [m]
REACH = 0.064         # from the flange to the plate under the magnet [m]
APPROACH = 0.15
SPEED = 0.5            # rad/s of the fastest joint

RACK = (0.50, 0.25)
RACK_TOP = 0.020
JIG = {"left": (0.42, -0.24), "right": (0.56, -0.24)}
JIG_TOP = 0.030


class Planner(object):
    def __init__(self):
        rospy.wait_for_service("/compute_ik")
        self.solve = rospy.ServiceProxy("/compute_ik", GetPositionIK)
        self.last = list(READY)

    def joints(self, x, y, z, yaw=0.0):
        request = GetPositionIKRequest()
        request.ik_request.group_name = "manipulator"
        request.ik_request.robot_state.joint_state = JointState(name=JOINTS, position=self.last)
        request.ik_request.pose_stamped = self._target(x, y, z, yaw)
        answer = self.solve(request)
        if answer.error_code.val != 1:
            raise ValueError("no solution for %.3f %.3f %.3f" % (x, y, z))
        state = dict(zip(answer.solution.joint_state.name, answer.solution.joint_state.position))
        self.last = [state[j] for j in JOINTS]
        return self.last

    @staticmethod
    def _target(x, y, z, yaw):
        target = PoseStamped()
        target.header.frame_id = "base_link"
        target.pose.position.x, target.pose.position.y, target.pose.position.z = x, y, z
        q = quaternion_from_euler(math.pi, 0.0, yaw)
        (target.pose.orientation.x, target.pose.orientation.y,
         target.pose.orientation.z, target.pose.orientation.w) = q
        return target


class Robot(object):
    def __init__(self):
        self.client = actionlib.SimpleActionClient(
            "/scaled_pos_joint_traj_controller/follow_joint_trajectory", FollowJointTrajectoryAction)
        self.client.wait_for_server()
        self.at = rospy.wait_for_message("/joint_states", JointState)
        self.at = [dict(zip(self.at.name, self.at.position))[j] for j in JOINTS]

    def go(self, *targets):
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        clock = 0.0
        for target in targets:
            clock += max(0.6, max(abs(a - b) for a, b in zip(target, self.at)) / SPEED)
            goal.trajectory.points.append(JointTrajectoryPoint(
                positions=target, velocities=[0.0] * 6, time_from_start=rospy.Duration(clock)))
            self.at = list(target)
        self.client.send_goal(goal)
        if not self.client.wait_for_result(rospy.Duration(clock + 5.0)):
            raise RuntimeError("trajectory timed out")


def carry(robot, planner, magnet, plate, level, side):
    x, y = RACK
    z = RACK_TOP + PLATE * (level + 1) + REACH
    robot.go(planner.joints(x, y, z + APPROACH), planner.joints(x, y, z))
    magnet.pick(plate)
    robot.go(planner.joints(x, y, z + APPROACH))
    x, y = JIG[side]
    z = JIG_TOP + PLATE + REACH
    robot.go(planner.joints(x, y, z + APPROACH), planner.joints(x, y, z + 0.001))
    magnet.drop()
    robot.go(planner.joints(x, y, z + APPROACH))


def main():
    rospy.init_node("plates")
    stock = rospy.Publisher("/rack/stock", Int16, queue_size=5)
    jig = rospy.Publisher("/jig/loaded", String, queue_size=5)
    robot, planner, magnet = Robot(), Planner(), Magnet()
    robot.go(READY)
    plates = [("plate_2", "left"), ("plate_1", "right")]   # from the top of the stack
    left_over = len(plates) + 1
    for plate, side in plates:
        carry(robot, planner, magnet, plate, left_over - 1, side)
        left_over -= 1
        jig.publish("%s:%s" % (side, plate))
        stock.publish(left_over)
    robot.go(READY)


if __name__ == "__main__":
    main()
