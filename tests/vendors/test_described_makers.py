"""Makers whose drivers are descriptions alone: Kinova's Jaco, UR's dashboard, Rethink's Sawyer."""

from __future__ import annotations

import pytest


def test_a_jaco_takes_joints_poses_and_fingers_as_actions(run_on):
    ran = run_on(
        "j2n6s300",
        """
import math
import actionlib, rospy
from geometry_msgs.msg import PoseStamped
from kinova_msgs.msg import *
rospy.init_node('jaco')
base = '/j2n6s300_driver/'
now = rospy.wait_for_message(base + 'out/joint_command', JointAngles)
tool = rospy.wait_for_message(base + 'out/tool_pose', PoseStamped)
state = rospy.wait_for_message(base + 'out/cartesian_command', KinovaPose)

def ask(name, kind, goal):
    client = actionlib.SimpleActionClient(base + name, kind)
    client.wait_for_server()
    client.send_goal(goal)
    assert client.wait_for_result(rospy.Duration(60))
    return client.get_result()

goal = ArmJointAnglesGoal()
goal.angles = now
goal.angles.joint1 += 30
reached = ask('joints_action/joint_angles', ArmJointAnglesAction, goal).angles
lower = ArmPoseGoal(pose=rospy.wait_for_message(base + 'out/tool_pose', PoseStamped))
lower.pose.pose.position.z -= 0.02
posed = ask('pose_action/tool_pose', ArmPoseAction, lower).pose
closed = ask('fingers_action/finger_positions', SetFingersPositionAction,
             SetFingersPositionGoal(FingerPosition(6800, 6800, 6800))).fingers
""",
    )
    assert ran["reached"].joint1 == pytest.approx(ran["now"].joint1, abs=0.5)
    assert ran["posed"].pose.position.z == pytest.approx(
        ran["lower"].pose.pose.position.z, abs=2e-3
    )
    assert ran["closed"].finger1 == pytest.approx(6800, abs=300)
    assert pytest.approx(ran["tool"].pose.position.x, abs=1e-3) == ran["state"].X
    assert ran.commands == ["joint_angles", "tool_pose", "finger_positions"]


def test_a_dashboard_tells_its_modes_and_programs_of_either_ros(run_on):
    ran = run_on(
        "ur5e",
        """
import rclpy
from std_srvs.srv import Trigger
from ur_dashboard_msgs.msg import RobotMode
from ur_dashboard_msgs.srv import GetProgramState, GetRobotMode, IsProgramRunning, Load
from ur_msgs.srv import SetForceMode
rclpy.init()
node = rclpy.create_node('dashboard')
def call(kind, name, **fields):
    client = node.create_client(kind, name)
    client.wait_for_service()
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()
loaded = call(Load, '/dashboard_client/load_program', filename='a.urp')
stopped = call(Trigger, '/dashboard_client/stop')
running = call(IsProgramRunning, '/dashboard_client/program_running')
call(Trigger, '/dashboard_client/play')
state = call(GetProgramState, '/dashboard_client/program_state')
call(Trigger, '/dashboard_client/power_off')
off = call(GetRobotMode, '/dashboard_client/get_robot_mode').robot_mode.mode
call(Trigger, '/dashboard_client/power_on')
on = call(GetRobotMode, '/dashboard_client/get_robot_mode').robot_mode.mode
force = call(SetForceMode, '/force_mode_controller/start_force_mode')
""",
        ros=2,
    )
    assert (ran["loaded"].success, ran["stopped"].success) == (True, True)
    assert ran["running"].program_running is False
    assert (ran["state"].state.state, ran["state"].program_name) == ("PLAYING", "a.urp")
    assert (ran["off"], ran["on"]) == (3, 7)
    assert ran["force"].success
    assert any("start_force_mode: forces" in each for each in ran.findings)


def test_a_trajectory_until_contact_runs_to_its_end(run_on):
    ran = run_on(
        "ur5e",
        """
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from ur_msgs.action import FollowJointTrajectoryUntil
rclpy.init()
node = rclpy.create_node('until')
client = ActionClient(node, FollowJointTrajectoryUntil, '/trajectory_until_node/execute')
client.wait_for_server()
names = ['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint',
         'wrist_1_joint', 'wrist_2_joint', 'wrist_3_joint']
point = JointTrajectoryPoint(positions=[0.4, -1.5, 1.0, -1.5, -1.5, 0.0],
                             time_from_start=Duration(sec=4))
goal = FollowJointTrajectoryUntil.Goal(
    trajectory=JointTrajectory(joint_names=names, points=[point]))
sent = client.send_goal_async(goal)
rclpy.spin_until_future_complete(node, sent)
ended = sent.result().get_result_async()
rclpy.spin_until_future_complete(node, ended)
result = ended.result().result
""",
        ros=2,
    )
    assert (ran["result"].error_code, ran["result"].until_condition_result) == (0, 1)
    assert ran.position("shoulder_pan_joint") == pytest.approx(0.4, abs=0.01)


def test_sawyer_has_its_parameters_states_and_kinematics(run_on):
    ran = run_on(
        "sawyer",
        """
import rospy
from geometry_msgs.msg import PoseStamped
from intera_core_msgs.msg import EndpointState, JointCommand, RobotAssemblyState
from intera_core_msgs.srv import SolvePositionIK, SolvePositionIKRequest
from sensor_msgs.msg import JointState
rospy.init_node('sawyer')
names = rospy.get_param('/robot_config/right_config/joint_names')
kind = rospy.get_param('/manifest/robot_class')
limbs = rospy.get_param('/robot_config/assembly_names')
state = rospy.wait_for_message('/robot/state', RobotAssemblyState)
joints = rospy.wait_for_message('/robot/joint_states', JointState)
before = rospy.wait_for_message('/robot/limb/right/endpoint_state', EndpointState)
height = before.pose.position.z
solve = rospy.ServiceProxy('/ExternalTools/right/PositionKinematicsNode/IKService', SolvePositionIK)
asked = SolvePositionIKRequest(tip_names=['right_hand'])
asked.pose_stamp.append(PoseStamped(pose=before.pose))
asked.pose_stamp[0].pose.position.z -= 0.05
found = solve(asked)
command = rospy.Publisher('/robot/limb/right/joint_command', JointCommand, queue_size=1)
goal = found.joints[0]
for _ in range(300):
    command.publish(JointCommand(mode=1, names=goal.name, position=goal.position))
    rospy.sleep(0.01)
after = rospy.wait_for_message('/robot/limb/right/endpoint_state', EndpointState)
asked.pose_stamp[0].pose.position.z += 5.0
far = solve(asked)
""",
    )
    assert ran["names"] == [f"right_j{i}" for i in range(7)]
    assert (ran["kind"], sorted(ran["limbs"])) == ("sawyer", ["head", "right", "torso"])
    assert (ran["state"].enabled, ran["state"].homed) == (True, True)
    assert list(ran["found"].result_type) == [1]
    assert ran["after"].pose.position.z == pytest.approx(ran["height"] - 0.05, abs=5e-3)
    assert list(ran["far"].result_type) == [-1]
