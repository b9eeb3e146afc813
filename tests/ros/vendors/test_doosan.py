"""The controller of a Doosan arm on the twin; units and answers as dsr_msgs2 has them."""

import math

import pytest

HEAD = """
import time
import rclpy
from dsr_msgs2.srv import *
from dsr_msgs2.msg import *
from std_msgs.msg import Float64MultiArray
rclpy.init()
node = rclpy.create_node('mover')
def call(kind, name, /, **fields):
    client = node.create_client(kind, '/dsr01/' + name)
    client.wait_for_service()
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()
def joints(*degrees, **fields):
    pos = [float(each) for each in degrees]
    return call(MoveJoint, 'motion/move_joint', pos=pos, **{'vel': 60.0, 'acc': 60.0, **fields})
def line(*pos, **fields):
    return call(MoveLine, 'motion/move_line', pos=[float(each) for each in pos], **fields)
def posx():
    return list(call(GetCurrentPosx, 'aux_control/get_current_posx').task_pos_info[0].data)
def posj():
    return list(call(GetCurrentPosj, 'aux_control/get_current_posj').pos)
home = (0, 0, 90, 0, 90, 0)
"""


def test_motions_in_degrees_and_millimetres_wait_for_their_end_or_not(run_on):
    ran = run_on(
        "m1013",
        HEAD
        + """
def go():
    return joints(20, 0, 90, 0, 90, 0)
begun = time.time()
first = go()
took = time.time() - begun
there = posj()
at = posx()
down = line(0, 0, -100, 0, 0, 0, vel=[100.0, 30.0], acc=[100.0, 30.0], mode=1)
after = posx()
begun = time.time()
later = joints(*home, sync_type=1)
at_once = time.time() - begun
busy = call(CheckMotion, 'motion/check_motion').status
call(MoveWait, 'motion/move_wait')
idle = call(CheckMotion, 'motion/check_motion').status
timed = time.time()
joints(10, 0, 90, 0, 90, 0, vel=0.0, acc=0.0, time=5.0)
timed = time.time() - timed
""",
        ros=2,
    )
    assert ran["first"].success
    assert ran["took"] > 1.0
    assert ran["there"] == pytest.approx([20, 0, 90, 0, 90, 0], abs=0.5)
    assert ran["down"].success
    assert ran["after"][:3] == pytest.approx([*ran["at"][:2], ran["at"][2] - 100], abs=3)
    # The tool looks down; the shoulder is left, the elbow above, the wrist not flipped.
    assert (ran["at"][4], ran["at"][6]) == (pytest.approx(180, abs=0.5), 2)
    assert ran["at_once"] < 0.5
    assert (ran["busy"], ran["idle"]) == (2, 0)
    assert ran["timed"] == pytest.approx(5.0, abs=0.5)
    assert set(ran.commands) == {"doosan_movej", "doosan_movel"}


def test_what_cannot_move_fails_and_says_so(run_on):
    ran = run_on(
        "m1013",
        HEAD
        + """
past = joints(0, 0, 200, 0, 90, 0)
still = joints(0, 0, 80, 0, 90, 0, vel=0.0)
far = line(3000, 0, 500, 0, 180, 0, vel=[100.0, 30.0], acc=[100.0, 30.0])
user = line(0, 0, 0, 0, 0, 0, vel=[100.0, 30.0], acc=[100.0, 30.0], ref=101)
paused = call(MovePause, 'motion/move_pause')
force = call(SetDesiredForce, 'force/set_desired_force')
grip = call(Robotiq2FOpen, 'gripper/robotiq_2f_open')
""",
        ros=2,
    )
    for name in ("past", "still", "far", "user", "paused", "force", "grip"):
        assert not ran[name].success, name
    assert ran.commands == []
    for reported in (
        "is outside its limits [-2.79",
        "velocity 0 and acceleration 60",
        "of the line to (3.000, 0.000, 0.500) m",
        "reference 101 is not simulated",
        "move_pause: not simulated",
        "set_desired_force: not simulated",
        "has no gripper with joints",
    ):
        assert any(reported in each for each in ran.findings), reported


@pytest.mark.slow
def test_circles_splines_spirals_and_sines_lead_where_they_should(run_on):
    ran = run_on(
        "m1013",
        HEAD
        + """
joints(*home)
start = posx()[:6]
def row(*values):
    return Float64MultiArray(data=[float(each) for each in values])
def off(x, y, z):
    return row(start[0] + x, start[1] + y, start[2] + z, *start[3:])
fast = {'vel': [250.0, 60.0], 'acc': [250.0, 60.0]}
circle = call(MoveCircle, 'motion/move_circle', pos=[off(50, 50, 0), off(100, 0, 0)], **fast)
ended = posx()[:3]
task = call(MoveSplineTask, 'motion/move_spline_task', pos=[off(50, 0, 50), off(0, 0, 0)], **fast)
back = posx()[:3]
spline = call(MoveSplineJoint, 'motion/move_spline_joint', vel=[60.0] * 6, acc=[60.0] * 6,
              pos=[row(10, 0, 90, 0, 90, 0), row(0, 10, 90, 0, 80, 0)])
turned = posj()
joints(*home)
spiral = call(MoveSpiral, 'motion/move_spiral', revolution=2.0, max_radius=30.0, max_length=20.0,
              task_axis=2, **fast)
wound = posx()[:3]
joints(*home)
sine = call(MovePeriodic, 'motion/move_periodic', amp=[20.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            periodic=[2.0, 0.0, 0.0, 0.0, 0.0, 0.0], repeat=2)
swung = posx()[:3]
""",
        ros=2,
    )
    for name in ("circle", "task", "spline", "spiral", "sine"):
        assert ran[name].success, (name, ran.findings)
    x, y, z = ran["start"][:3]
    assert ran["ended"] == pytest.approx([x + 100, y, z], abs=3)
    assert ran["back"] == pytest.approx([x, y, z], abs=3)
    assert ran["turned"] == pytest.approx([0, 10, 90, 0, 80, 0], abs=0.5)
    assert ran["wound"] == pytest.approx([x + 30, y, z + 20], abs=3)
    assert ran["swung"] == pytest.approx([x, y, z], abs=3)


def test_streams_tools_and_kinematics(run_on):
    ran = run_on(
        "m1013",
        HEAD
        + """
joints(*home)
there = list(call(Fkin, 'motion/fkin', pos=[float(each) for each in home]).conv_posx)
flange = posx()[:3]
call(ConfigCreateTcp, 'tcp/config_create_tcp', name='tip', pos=[0.0, 0.0, 100.0, 0.0, 0.0, 0.0])
call(SetCurrentTcp, 'tcp/set_current_tcp', name='tip')
tip = posx()[:3]
speeds = node.create_publisher(SpeedjStream, '/dsr01/speedj_stream', 1)
speeds.publish(SpeedjStream(vel=[10.0, 0.0, 0.0, 0.0, 0.0, 0.0], time=2.0))
time.sleep(3.0)
turned = posj()[0]
call(SetRobotMode, 'system/set_robot_mode', robot_mode=0)
mode = call(GetRobotMode, 'system/get_robot_mode').robot_mode
""",
        ros=2,
    )
    assert ran["there"][:3] == pytest.approx(ran["flange"], abs=1)
    assert ran["tip"][2] == pytest.approx(ran["flange"][2] - 100, abs=2)
    assert ran["turned"] == pytest.approx(20.0, abs=1.0)
    assert ran["mode"] == 0
    assert ran.position("joint_3") == pytest.approx(math.pi / 2, abs=0.02)


def test_tools_that_are_registered_in_the_box_are_an_assumption(run_on):
    ran = run_on(
        "m1013",
        HEAD
        + """
tcp = call(SetCurrentTcp, 'tcp/set_current_tcp', name='gripper_tip')
tool = call(SetCurrentTool, 'tool/set_current_tool', name='gripper')
again = call(SetCurrentTcp, 'tcp/set_current_tcp', name='gripper_tip')
asked = call(GetCurrentTcp, 'tcp/get_current_tcp')
""",
        ros=2,
    )
    assert ran["tcp"].success
    assert ran["tool"].success
    assert ran["again"].success
    assert ran["asked"].info == "gripper_tip"
    assert {finding.kind for finding in ran.recording.findings} == {"assumed_setting"}
    first, second = ran.findings
    assert "tool centre point 'gripper_tip' is not created by the controller" in first
    assert "tool 'gripper'" in second
