"""Makers whose drivers are descriptions alone: Kinova's Jaco, UR's dashboard, Rethink's Sawyer."""

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


def test_a_dashboard_says_its_modes_and_programs_of_either_ros(run_on):
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


@pytest.mark.slow
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
version = rospy.get_param('/manifest/robot_software/version/HLR_VERSION_STRING')
limbs = rospy.get_param('/robot_config/assembly_names')
neutral = rospy.get_param('/named_poses/right/poses/neutral')
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
    assert ran["version"] == "5.3.0"  # a library compares it with its own
    at = dict(zip(ran["joints"].name, ran["joints"].position, strict=True))
    assert ran["neutral"] == pytest.approx([at[name] for name in ran["names"]], abs=1e-6)
    assert (ran["state"].enabled, ran["state"].homed) == (True, True)
    assert list(ran["found"].result_type) == [1]
    assert ran["after"].pose.position.z == pytest.approx(ran["height"] - 0.05, abs=5e-3)
    assert list(ran["far"].result_type) == [-1]


def test_a_ned_of_ros_2_moves_by_its_commands(run_on):
    ran = run_on(
        "niryo_ned2",
        """
import rclpy
from niryo_ned_ros2_interfaces.action import RobotMove, Tool
from niryo_ned_ros2_interfaces.msg import ArmMoveCommand, DigitalIOState, ToolCommand
from niryo_ned_ros2_interfaces.srv import ControlConveyor, SetInt
from rclpy.action import ActionClient
rclpy.init()
node = rclpy.create_node('ned')
def ask(kind, name, **fields):
    client = ActionClient(node, kind, name)
    client.wait_for_server()
    command = (ArmMoveCommand if kind is RobotMove else ToolCommand)(**fields)
    sent = client.send_goal_async(kind.Goal(cmd=command))
    rclpy.spin_until_future_complete(node, sent)
    ended = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, ended)
    return ended.result().result
slow = node.create_client(SetInt, '/niryo_robot_arm_commander/set_max_velocity_scaling_factor')
slow.wait_for_service()
rclpy.spin_until_future_complete(node, slow.call_async(SetInt.Request(value=20)))
belt = node.create_client(ControlConveyor, '/niryo_robot/conveyor/control_conveyor')
belt.wait_for_service()
ran = belt.call_async(ControlConveyor.Request(id=9, control_on=True, speed=100, direction=1))
rclpy.spin_until_future_complete(node, ran)
belt_status = ran.result().status
begun = node.get_clock().now().nanoseconds
joints = ask(RobotMove, '/niryo_robot_arm_commander/robot_action',
             cmd_type=0, joints=[0.5, 0.2, -0.5, 0.0, 0.0, 0.0])
took = (node.get_clock().now().nanoseconds - begun) * 1e-9
shift = ask(RobotMove, '/niryo_robot_arm_commander/robot_action', cmd_type=6)
grip = ask(Tool, '/niryo_robot_tools_commander/action_server/tool_action', cmd_type=2)
other = ask(Tool, '/tools/tool_action', cmd_type=10)
again = ask(Tool, '/niryo_robot_tools_commander/action_server', cmd_type=1)
states = []
node.create_subscription(DigitalIOState, '/niryo_robot_rpi/digital_io_state', states.append, 10)
while not states:
    rclpy.spin_once(node, timeout_sec=1.0)
inputs = [each.value for each in states[0].digital_inputs]
""",
        ros=2,
    )
    assert [ran[name].status for name in ("joints", "shift", "grip", "other")] == [1, -52, 1, 1]
    assert (ran["again"].status, ran["belt_status"]) == (1, 1)
    assert ran["inputs"] == [False] * 5
    assert ran["took"] > 1.5
    assert ran.position("joint_1") == pytest.approx(0.5, abs=0.01)


def test_play_motion_plays_what_the_parameters_hold(run_on):
    ran = run_on(
        "tiago",
        """
import actionlib, rospy
from play_motion_msgs.msg import PlayMotionAction, PlayMotionGoal
rospy.init_node('player')
names = ['arm_%d_joint' % i for i in range(1, 8)]
rospy.set_param('/play_motion/motions/reach', {
    'joints': ['head_1_joint'] + names,
    'points': [
        {'positions': [0.1, 0.3, -0.5, -1.0, 1.5, -1.5, 0.1, 0.0], 'time_from_start': 2.0},
        {'positions': [0.1, 0.6, -0.4, -1.0, 1.2, -1.5, 0.1, 0.0], 'time_from_start': 4.0},
    ],
})
client = actionlib.SimpleActionClient('/play_motion', PlayMotionAction)
client.wait_for_server()
done = client.send_goal_and_wait(PlayMotionGoal(motion_name='reach'))
unknown = client.send_goal_and_wait(PlayMotionGoal(motion_name='rech'))
told = client.get_result().error_string
""",
    )
    assert (ran["done"], ran["unknown"]) == (3, 4)
    assert ran.position("arm_1_joint") == pytest.approx(0.6, abs=0.01)
    assert "no named state or motion 'rech'; did you mean 'reach'?" in ran["told"]


def test_a_motion_of_the_parameters_comes_before_a_state_of_that_name(run_on):
    ran = run_on(
        "panda",
        """
import actionlib, rospy
from play_motion_msgs.msg import PlayMotionAction, PlayMotionGoal
rospy.init_node('player')
rospy.set_param('/play_motion/motions/ready', {
    'joints': ['panda_joint%d' % i for i in range(1, 8)],
    'points': [{'positions': [0.4, -0.7, 0.0, -2.3, 0.0, 1.5, 0.7], 'time_from_start': 2.0}],
})
client = actionlib.SimpleActionClient('/play_motion', PlayMotionAction)
client.wait_for_server()
done = client.send_goal_and_wait(PlayMotionGoal(motion_name='ready'))
""",
    )
    assert ran["done"] == 3
    assert ran.position("panda_joint1") == pytest.approx(0.4, abs=0.01)


def test_sawyers_motion_controller_goes_through_joints_or_to_a_pose(run_on):
    ran = run_on(
        "sawyer",
        """
import actionlib, rospy
from geometry_msgs.msg import PoseStamped
from intera_core_msgs.msg import EndpointState
from intera_motion_msgs.msg import MotionCommandAction, MotionCommandGoal, Waypoint
rospy.init_node('mover')
client = actionlib.SimpleActionClient('/motion/motion_command', MotionCommandAction)
client.wait_for_server()
def go(*points, command='start'):
    goal = MotionCommandGoal(command=command)
    goal.trajectory.joint_names = ['right_j%d' % i for i in range(7)]
    for point in points:
        point.options.max_joint_speed_ratio = 0.5
    goal.trajectory.waypoints = list(points)
    client.send_goal_and_wait(goal)
    return client.get_result().result
there = dict(active_endpoint='right_hand', joint_positions=[0.0, -0.9, 0.0, 1.8, 0.0, -0.9, 0.0])
# The same point twice is no motion of its own.
joints = go(Waypoint(**there), Waypoint(**there))
state = rospy.wait_for_message('/robot/limb/right/endpoint_state', EndpointState)
before = state.pose.position.z
place = PoseStamped(pose=state.pose)
place.pose.position.z += 0.05
pose = go(Waypoint(active_endpoint='right_hand', pose=place))
after = rospy.wait_for_message('/robot/limb/right/endpoint_state', EndpointState)
height = after.pose.position.z - before
kept = go(Waypoint(**there), command='generate')
""",
    )
    assert (ran["joints"], ran["pose"], ran["kept"]) == (True, True, False)
    assert ran["height"] == pytest.approx(0.05, abs=5e-3)
