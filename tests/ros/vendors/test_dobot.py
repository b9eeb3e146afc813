"""The driver of a Dobot arm on the twin; units and codes as the list of its commands has them."""

import math

import pytest

HEAD = """
import time
import rclpy
from dobot_msgs_v4.srv import *
from dobot_msgs_v4.msg import *
rclpy.init()
node = rclpy.create_node('mover')
def call(kind, /, **fields):
    client = node.create_client(kind, '/dobot_bringup_ros2/srv/' + kind.__name__)
    client.wait_for_service()
    future = client.call_async(kind.Request(**fields))
    rclpy.spin_until_future_complete(node, future)
    return future.result()
def six(*values, **fields):
    return {**dict(zip('abcdef', (float(each) for each in values))), **fields}
def numbers(kind, /, **fields):
    return [float(each) for each in call(kind, **fields).robot_return.strip('{}').split(',')]
def finish():
    while numbers(RobotMode)[0] == 7:
        time.sleep(0.05)
call(EnableRobot)
"""


def test_motions_queue_and_are_those_of_their_function(run_on):
    ran = run_on(
        "cr5",
        HEAD
        + """
def turn():
    return call(MovJ, **six(0, 20, -90, -20, -90, 0, mode=True))
begun = time.time()
first = turn()
at_once = time.time() - begun
running = numbers(RobotMode)[0]
second = call(RelMovLUser, **six(0, 0, 50, 0, 0, 0))
finish()
took = time.time() - begun
angles = numbers(GetAngle)
pose = numbers(GetPose)
done = numbers(GetCurrentCommandId)[0]
begun = time.time()
call(SpeedFactor, ratio=20)
call(MovL, **six(*pose[:2], pose[2] - 50, *pose[3:], mode=False, param_value=['speed=100']))
finish()
slow = time.time() - begun
after = numbers(GetPose)
""",
        ros=2,
    )
    assert (ran["first"].res, ran["second"].res) == (0, 0)
    assert ran["at_once"] < 0.5
    assert ran["running"] == 7
    assert ran["done"] == 2
    assert ran["slow"] > 2.4
    assert ran["after"][:3] == pytest.approx([*ran["pose"][:2], ran["pose"][2] - 50], abs=2)
    assert ran.commands == ["dobot_MovJ", "dobot_RelMovLUser", "dobot_MovL"]
    assert "turn" in ran.owners


def test_a_goal_out_of_reach_sets_an_error_until_it_is_cleared(run_on):
    ran = run_on(
        "cr5",
        HEAD
        + """
far = call(MovL, **six(3000, 0, 500, 180, 0, 0, mode=False))
mode = numbers(RobotMode)[0]
refused = call(MovJ, **six(0, 0, 0, 0, 0, 0, mode=True))
call(ClearError)
taken = call(MovJ, **six(0, 10, 0, 0, 0, 0, mode=True))
finish()
call(DisableRobot)
disabled = call(MovJ, **six(0, 0, 0, 0, 0, 0, mode=True))
call(EnableRobot)
odd = call(MovJ, **six(0, 0, 0, 0, 0, 0, mode=True, param_value=['w=3']))
frame = call(MovJ, **six(0, 0, 0, 0, 0, 0, mode=True, param_value=['user=2']))
late = call(ServoJ, **six(0, 0, 0, 0, 0, 0, param_value=['t=0.001']))
speed = call(SpeedFactor, ratio=0)
paused = call(Pause)
pin = call(DO, index=1, status=1)
""",
        ros=2,
    )
    assert (ran["far"].res, ran["mode"], ran["refused"].res) == (0, 9, -2)
    assert (ran["taken"].res, ran["disabled"].res) == (0, -4)
    assert (ran["odd"].res, ran["frame"].res, ran["late"].res) == (-30001, -30001, -40001)
    assert (ran["speed"].res, ran["paused"].res, ran["pin"].res) == (-40001, -1, 0)
    for reported in (
        "of the line to (3.000, 0.000, 0.500) m",
        "MovJ moved nothing: it returned -2",
        "parameter 'w=3'; allowed",
        "user frame 2 is not simulated",
        "Pause is not simulated",
        "DO 1 was set: nothing hangs on it",
    ):
        assert any(reported in each for each in ran.findings), reported


@pytest.mark.slow
def test_set_points_are_one_command_and_jogging_stops(run_on):
    ran = run_on(
        "cr5",
        HEAD
        + """
def stream():
    for i in range(40):
        call(ServoJ, **six(i * 0.5, 0, 0, 0, 0, 0, param_value=['t=0.05']))
        time.sleep(0.05)
stream()
time.sleep(1.0)
there = numbers(GetAngle)[0]
call(SpeedFactor, ratio=20)
call(MoveJog, axis_id='J1+')
time.sleep(0.5)
call(MoveJog, axis_id='')
jogged = numbers(GetAngle)[0]
time.sleep(0.5)
still = numbers(GetAngle)[0]
wrong = call(MoveJog, axis_id='Q')
here = numbers(GetPose)
back = numbers(PositiveKin, **{f'j{i + 1}': each for i, each in enumerate(numbers(GetAngle))})
""",
        ros=2,
    )
    assert ran["there"] == pytest.approx(19.5, abs=0.5)
    assert ran.commands == ["dobot_servo", "dobot_MoveJog"]
    assert ran["jogged"] > ran["there"] + 10
    assert ran["still"] == pytest.approx(ran["jogged"], abs=8)
    assert ran["wrong"].res == -30001
    assert ran["back"][:3] == pytest.approx(ran["here"][:3], abs=1)
    assert ran.position("joint1") == pytest.approx(math.radians(ran["still"]), abs=0.02)
