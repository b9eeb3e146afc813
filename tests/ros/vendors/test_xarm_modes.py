"""Modes and states of an xArm: what moves it in which, what it answers, and its streams.

Sources: xArm-Developer/xarm_ros `ReadMe.md` (Robot Mode 0 to 7), `xarm_msgs/msg/RobotMsg.msg`
(states), xArm-Developer/xArm-CPLUS-SDK `src/xarm/wrapper/xarm_api.cc` (`_check_code`).
"""

import pytest

ROS_1 = """
import rospy
from xarm_msgs.srv import *
rospy.init_node('mover')
rospy.set_param('/xarm/wait_for_finish', True)
def call(name, kind, *values):
    rospy.wait_for_service('/xarm/' + name)
    return rospy.ServiceProxy('/xarm/' + name, kind)(*values)
def put(mode):
    return call('set_mode', SetInt16, mode).ret, call('set_state', SetInt16, 0).ret
call('motion_ctrl', SetAxis, 8, 1)
JOINTS = [0.2, -0.2, 0.0, 0.4, 0.0, -0.9, 0.0]
"""
ROS_2 = """
import rclpy, time
from xarm_msgs.srv import *
rclpy.init()
node = rclpy.create_node('mover')
clients = {}
def call(name, kind, **fields):
    if name not in clients:
        clients[name] = node.create_client(kind, '/xarm/' + name)
        clients[name].wait_for_service()
    future = clients[name].call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()
def put(mode):
    return (call('set_mode', SetInt16, data=mode).ret, call('set_state', SetInt16, data=0).ret)
call('motion_enable', SetInt16ById, id=8, data=1)
JOINTS = [0.2, -0.2, 0.0, 0.4, 0.0, -0.9, 0.0]
"""
IN_WRONG_MODES = {
    # what: (program, mode, call, the mode in which it moves)
    "a motion of joints": (ROS_1, 1, "'move_joint', Move, JOINTS, 0.5, 5.0, 0, 0", 0),
    "the way home": (ROS_1, 1, "'go_home', Move, [], 0.5, 5.0, 0, 0", 0),
    "a line": (ROS_1, 4, "'move_line', Move, [300.0, 0, 300, 3.14, 0, 0], 50, 500, 0, 0", 0),
    "a joint set-point": (ROS_1, 0, "'move_servoj', Move, [0.01] * 7, 0, 0, 0, 0", 1),
    "a velocity": (ROS_1, 0, "'velo_move_joint', MoveVelo, [0.1] * 7, 1, 0", 4),
    "a velocity of the tool": (ROS_1, 4, "'velo_move_line', MoveVelo, [30.0] + [0] * 5, 0, 0", 5),
    "joints of ROS 2": (ROS_2, 1, "'set_servo_angle', MoveJoint, angles=JOINTS, wait=True", 0),
    "home in ROS 2": (ROS_2, 2, "'move_gohome', MoveHome, wait=True", 0),
    "a set-point of ROS 2": (ROS_2, 0, "'set_servo_angle_j', MoveJoint, angles=[0.01] * 7", 1),
    "a pose of a stream": (
        ROS_2, 6, "'set_servo_cartesian', MoveCartesian, pose=[300.0, 0, 300, 3.14, 0, 0]", 1,
    ),
}  # fmt: skip


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("what", IN_WRONG_MODES)
def test_what_is_asked_for_in_a_wrong_mode_is_answered_with_0_and_moves_nothing(run_on, what):
    head, mode, asked, right = IN_WRONG_MODES[what]
    ran = run_on(
        "xarm7",
        f"{head}\nmodes = put({mode})\nanswer = call({asked})\n",
        ros=2 if head is ROS_2 else 1,
    )
    assert (ran["modes"], ran["answer"].ret) == ((0, 0), 0)
    assert ran.recording.commands == ()
    (finding,) = [each for each in ran.recording.findings if each.kind == "command_ignored"]
    assert f"moved nothing: the arm is in mode {mode}, and this moves it in mode" in finding.message
    assert f"set mode {right}, then state 0" in finding.message


@pytest.mark.parametrize(("head", "ros"), [(ROS_1, 1), (ROS_2, 2)])
def test_after_a_mode_is_set_nothing_moves_until_its_state_is(run_on, head, ros):
    data = ("data=" * (ros == 2)) + "0"
    motion = {
        1: "call('move_joint', Move, JOINTS, 0.5, 5.0, 0, 0).ret",
        2: "call('set_servo_angle', MoveJoint, angles=JOINTS, wait=True).ret",
    }[ros]
    ran = run_on(
        "xarm7",
        f"{head}\ncall('set_mode', SetInt16, {data})\nbefore = {motion}\n"
        f"call('set_state', SetInt16, {data})\nafter = {motion}\n",
        ros=ros,
    )
    assert (ran["before"], ran["after"]) == (9, 0)
    assert ran.position("joint1") == pytest.approx(0.2, abs=0.01)
    assert any(
        "a new mode or a new offset of the tool set its state to 0" in each for each in ran.findings
    )


def test_in_mode_6_a_new_goal_takes_the_place_of_the_one_before(run_on):
    ran = run_on(
        "xarm7",
        ROS_2
        + """
put(6)
call('set_servo_angle', MoveJoint, angles=[1.5] + [0.0] * 6, speed=0.5)
time.sleep(1.0)
call('set_servo_angle', MoveJoint, angles=[-0.2] + [0.0] * 6, speed=0.5)
time.sleep(4.0)
""",
        ros=2,
    )
    assert ran.position("joint1") == pytest.approx(-0.2, abs=0.01)
    moved = ran.recording.commands
    assert len(moved) == 2
    assert moved[0].way_done is None or moved[0].way_done < 0.6


def test_an_error_puts_the_arm_into_mode_0(run_on):
    ran = run_on(
        "xarm7",
        ROS_1
        + """
from xarm_msgs.msg import RobotMsg
def mode():
    return rospy.wait_for_message('/xarm/xarm_states', RobotMsg).mode
put(7)
before = mode()
failed = call('move_line', Move, [2000.0, 0, 300, 3.14, 0, 0], 50, 500, 0, 0).ret
call('clear_err', ClearErr)
call('set_state', SetInt16, 0)
after = mode()
""",
    )
    assert (ran["before"], ran["failed"], ran["after"]) == (7, 1, 0)


def test_a_stop_of_the_state_ends_a_motion_and_holds_the_next(run_on):
    ran = run_on(
        "xarm7",
        ROS_2
        + """
put(0)
call('set_servo_angle', MoveJoint, angles=[1.5] + [0.0] * 6, speed=0.5)
time.sleep(1.0)
call('set_state', SetInt16, data=4)
refused = call('set_servo_angle', MoveJoint, angles=JOINTS, wait=True).ret
""",
        ros=2,
    )
    assert ran["refused"] == 9
    assert 0.1 < ran.position("joint1") < 1.0


# Trajectories, which the hardware interface carries out in mode 1

GOAL = """
from control_msgs.action import FollowJointTrajectory
from builtin_interfaces.msg import Duration
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
def goal(joint1):
    client = ActionClient(
        node, FollowJointTrajectory, '/xarm7_traj_controller/follow_joint_trajectory')
    client.wait_for_server()
    point = JointTrajectoryPoint(positions=[joint1] + [0.0] * 6, time_from_start=Duration(sec=3))
    asked = FollowJointTrajectory.Goal()
    asked.trajectory = JointTrajectory(
        joint_names=[f'joint{n}' for n in range(1, 8)], points=[point])
    sent = client.send_goal_async(asked)
    rclpy.spin_until_future_complete(node, sent)
    result = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, result)
    return result.result().status
"""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("steps", "status"),
    [("", 4), ("put(0)\n", 6), ("put(0)\nput(1)\n", 4), ("put(6)\n", 6), ("put(4)\n", 4)],
)
def test_a_trajectory_is_carried_out_in_the_mode_of_its_controllers(run_on, steps, status):
    ran = run_on("xarm7", ROS_2 + GOAL + steps + "status = goal(0.3)\n", ros=2)
    assert ran["status"] == status
    assert bool(ran.recording.commands) == (status == 4)
    assert any("carries out no trajectories" in each for each in ran.findings) == (status == 6)


# Streams

SERVO = """
put(1)
for step in range(100):
    call('{name}', MoveJoint, angles=[0.005 * step] + [0.0] * 6)
    time.sleep({period})
time.sleep(1.0)
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("period", [0.02, 0.01, 0.005])
def test_set_points_of_calls_are_one_stream_at_any_rate(run_on, period):
    ran = run_on("xarm7", ROS_2 + SERVO.format(name="set_servo_angle_j", period=period), ros=2)
    assert ran.commands == ["set_servo_angle_j"]
    assert [command.end for command in ran.recording.commands] == ["arrived"]
    assert ran.position("joint1") == pytest.approx(0.495, abs=0.005)


TOOL = """
call('move_joint', Move, [0.0, -0.3, 0.0, 0.8, 0.0, 1.1, 0.0], 0.8, 8.0, 0, 0)
def pose():
    return list(call('get_position_rpy', GetFloat32List).datas)
put(1)
before = pose()
for step in range(1, 51):
    call('move_servo_cart', Move, {step}, 0, 0, {tool}, 0)
    rospy.sleep(0.01)
rospy.sleep(0.5)
after = pose()
way = [b - a for a, b in zip(before[:3], after[:3])]
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("step", "tool", "way"),
    [
        ("[before[0] + 0.5 * step, *before[1:6]]", 0, (25.0, 0.0, 0.0)),
        ("[before[0], before[1], before[2] + 0.5 * step, *before[3:6]]", 0, (0.0, 0.0, 25.0)),
    ],
)
def test_poses_of_a_stream_lead_the_tool(run_on, step, tool, way):
    ran = run_on("xarm7", ROS_1 + TOOL.format(step=step, tool=tool))
    assert ran["way"] == pytest.approx(way, abs=1.0)
    assert ran.commands == ["move_joint", "move_servo_cart"]


def test_steps_in_the_axes_of_the_tool_add_up(run_on):
    ran = run_on("xarm7", ROS_1 + TOOL.format(step="[0, 0, 0.5, 0, 0, 0]", tool=1))
    assert sum(each**2 for each in ran["way"]) ** 0.5 == pytest.approx(25.0, abs=1.0)


# The offset of the tool

OFFSET = {
    1: (
        ROS_1,
        "call('move_joint', Move, [0.0, -0.3, 0.0, 0.8, 0.0, 1.1, 0.0], 0.8, 8.0, 0, 0)",
        "list(call('get_position_rpy', GetFloat32List).datas)",
        "call('set_tcp_offset', TCPOffset, 0, 0, {}, 0, 0, 0).ret",
        "call('move_line', Move, {}, 80, 500, 0, 0).ret",
    ),
    2: (
        ROS_2,
        "call('set_servo_angle', MoveJoint, angles=[0.0, -0.3, 0.0, 0.8, 0.0, 1.1, 0.0], speed=0.8, wait=True)",
        "list(call('get_position', GetFloat32List).datas)",
        "call('set_tcp_offset', SetFloat32List, datas=[0.0, 0.0, {}, 0.0, 0.0, 0.0]).ret",
        "call('set_position', MoveCartesian, pose={}, speed=80.0, wait=True).ret",
    ),
}  # fmt: skip


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize("length", [100.0, -50.0])
def test_poses_are_of_the_tool_whose_offset_is_set(run_on, ros, length):
    head, ready, pose, offset, line = OFFSET[ros]
    zero = "data=" * (ros == 2) + "0"
    ran = run_on(
        "xarm7",
        f"{head}\n{ready}\nflange = {pose}\nset_ = {offset.format(length)}\n"
        f"held = {line.format('flange[:6]')}\ncall('set_state', SetInt16, {zero})\n"
        f"tool = {pose}\nback = {line.format('flange[:6]')}\n{offset.format(0.0)}\nraised = {pose}\n",
        ros=ros,
    )
    # A new offset is a new configuration: not ready for motions.
    assert (ran["set_"], ran["held"], ran["back"]) == (0, 9, 0)
    apart = [b - a for a, b in zip(ran["flange"][:3], ran["tool"][:3], strict=True)]
    assert sum(each**2 for each in apart) ** 0.5 == pytest.approx(abs(length), abs=0.5)
    raised = [b - a for a, b in zip(ran["flange"][:3], ran["raised"][:3], strict=True)]
    assert raised == pytest.approx([-each for each in apart], abs=1.0)
