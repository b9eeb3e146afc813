"""The nodes of a Niryo arm on the twin; names, units and numbers as ned_ros has them."""

import pytest

HEAD = """
import rospy, actionlib
from niryo_robot_msgs.srv import *
from niryo_robot_msgs.msg import *
from niryo_robot_arm_commander.srv import *
from niryo_robot_arm_commander.msg import *
from niryo_robot_tools_commander.msg import *
from geometry_msgs.msg import Point
rospy.init_node('mover')
mover = actionlib.SimpleActionClient('/niryo_robot_arm_commander/robot_action', RobotMoveAction)
mover.wait_for_server()
def call(name, kind, *values):
    rospy.wait_for_service(name, 2)
    return rospy.ServiceProxy(name, kind)(*values)
def move(cmd_type, **fields):
    mover.send_goal(RobotMoveGoal(cmd=ArmMoveCommand(cmd_type=cmd_type, **fields)))
    mover.wait_for_result()
    return mover.get_state(), mover.get_result()
def state():
    return rospy.wait_for_message('/niryo_robot/robot_state', RobotState)
"""


def test_moves_of_joints_and_poses_are_those_of_their_function(run_on):
    ran = run_on(
        "niryo_ned2",
        HEAD
        + """
def reach():
    return move(ArmMoveCommand.JOINTS, joints=[0.3, 0.0, -0.5, 0.0, 0.0, 0.0])
first = reach()
forward = call('/niryo_robot/kinematics/forward', GetFK, [0.3, 0.0, -0.5, 0.0, 0.0, 0.0])
here = state()
def shift():
    return move(ArmMoveCommand.SHIFT_LINEAR_POSE, shift=ShiftPose(2, -0.03))
second = shift()
there = state()
past = move(ArmMoveCommand.JOINTS, joints=[9.0, 0, 0, 0, 0, 0])
far = move(ArmMoveCommand.POSE, position=Point(2.0, 0.0, 0.2))
odd = move(77)
""",
    )
    assert (ran["first"][0], ran["first"][1].status) == (3, 1)
    assert ran["second"][0] == 3
    assert ran["here"].position.z == pytest.approx(ran["forward"].pose.position.z, abs=0.003)
    assert ran["here"].position.z - ran["there"].position.z == pytest.approx(0.03, abs=0.003)
    assert ran.commands == ["niryo_move", "niryo_move"]
    assert ran.owners == ["reach", "shift"]
    assert (ran["past"][0], ran["past"][1].status) == (4, -52)
    assert (ran["far"][0], ran["far"][1].status) == (4, -232)
    assert (ran["odd"][0], ran["odd"][1].status) == (4, -52)
    assert any("cmd_type 77; allowed: 0 to 12" in each for each in ran.findings)


def test_the_tool_opens_and_closes_and_another_tool_is_a_need(run_on):
    ran = run_on(
        "niryo_ned2",
        HEAD
        + """
tool = actionlib.SimpleActionClient('/niryo_robot_tools_commander/action_server', ToolAction)
tool.wait_for_server()
def use(kind):
    tool.send_goal(ToolGoal(cmd=ToolCommand(cmd_type=kind, tool_id=11)))
    tool.wait_for_result()
    return tool.get_state(), tool.get_result().status
closed = use(ToolCommand.CLOSE_GRIPPER)
opened = use(ToolCommand.OPEN_GRIPPER)
pump = use(ToolCommand.PULL_AIR_VACUUM_PUMP)
""",
    )
    assert ran["closed"] == (3, 1)
    assert ran["opened"] == (3, 1)
    assert ran.position("joint_base_to_mors_1") == pytest.approx(0.007, abs=0.003)
    assert ran["pump"] == (3, 1)
    (finding,) = ran.recording.findings
    assert (finding.kind, finding.object) == (
        "unprovided", "/niryo_robot_tools_commander/action_server",
    )  # fmt: skip
    assert "tool 11 is asked for cmd_type 10, and the twin has no pump" in finding.message


def test_an_update_finds_the_tool_that_is_mounted(run_on):
    ran = run_on(
        "niryo_ned2",
        HEAD
        + """
from std_msgs.msg import Int32
status = call('/niryo_robot_tools_commander/update_tool', Trigger).status
tool = rospy.wait_for_message('/niryo_robot_tools_commander/current_id', Int32).data
""",
    )
    assert (ran["status"], ran["tool"] > 0, ran.findings) == (1, True, [])


def test_speed_stops_home_and_parameters(run_on):
    ran = run_on(
        "niryo_ned2",
        HEAD
        + """
def timed(percent, goal):
    call('/niryo_robot_arm_commander/set_max_velocity_scaling_factor', SetInt, percent)
    begun = rospy.get_time()
    move(ArmMoveCommand.JOINTS, joints=[goal, 0, 0, 0, 0, 0])
    return rospy.get_time() - begun
fast, slow = timed(100, 1.5), timed(20, 0.0)
none = call('/niryo_robot_arm_commander/set_max_velocity_scaling_factor', SetInt, 0)
mover.send_goal(RobotMoveGoal(cmd=ArmMoveCommand(cmd_type=0, joints=[2.0, 0, 0, 0, 0, 0])))
rospy.sleep(0.5)
call('/niryo_robot_arm_commander/stop_command', Trigger)
mover.wait_for_result()
stopped = mover.get_state(), mover.get_result().status
home = call('/niryo_robot_joints_interface/get_home_position', GetFloatList)
stored = call('/niryo_robot_arm_commander/manage_trajectory', ManageTrajectory, ManageTrajectoryRequest())
version = rospy.get_param('/niryo_robot/hardware_version')
""",
    )
    assert ran["slow"] > 2 * ran["fast"]
    assert ran["none"].status == -52
    assert ran["stopped"] == (2, -4)
    assert list(ran["home"].values) == pytest.approx([0, 0.6, -1.3, 0, 0, 0])
    assert ran["stored"].status == -51
    assert ran["version"] == "ned2"


def test_poses_and_frames_are_remembered_and_frames_are_transforms(run_on):
    ran = run_on(
        "niryo_ned2",
        HEAD
        + """
import tf2_ros
from niryo_robot_poses_handlers.srv import *
from niryo_robot_poses_handlers.msg import *
places = '/niryo_robot_poses_handlers/'
call(places + 'manage_pose', ManagePose, 1, NiryoPose(name='a', joints=[0.1] * 6))
pose = call(places + 'get_pose', GetPose, 'a')
missing = call(places + 'get_pose', GetPose, 'b')
points = [Point(0.2, 0.1, 0.0), Point(0.2, 0.2, 0.0), Point(0.1, 0.1, 0.0)]
saved = call(places + 'manage_dynamic_frame', ManageDynamicFrame, 2, DynamicFrame(name='f', points=points))
line = [Point(0, 0, 0), Point(1, 0, 0), Point(2, 0, 0)]
flat = call(places + 'manage_dynamic_frame', ManageDynamicFrame, 2, DynamicFrame(name='g', points=line))
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
found = buffer.lookup_transform('world', 'f', rospy.Time(0), rospy.Duration(4.0)).transform
listed = rospy.wait_for_message(places + 'dynamic_frame_list', BasicObjectArray, 2)
""",
    )
    assert list(ran["pose"].pose.joints) == [0.1] * 6
    assert ran["missing"].status == -302
    assert "no pose 'b'; known: a" in ran["missing"].message
    assert ran["saved"].status == 1
    assert ran["flat"].status == -306
    assert ran["found"].translation.x == pytest.approx(0.2)
    assert abs(ran["found"].rotation.z) == pytest.approx(0.7071, abs=1e-3)
    assert [each.name for each in ran["listed"].objects] == ["f"]
