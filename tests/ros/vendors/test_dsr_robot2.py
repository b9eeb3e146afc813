"""Doosan's library DSR_ROBOT2 as programs use it, on the controller that the twin serves."""

from pathlib import Path
from typing import Any

import pytest

from tests.ran import Ran
from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros2 import Interfaces2

BEGIN = """
import rclpy
import DR_init

DR_init.__dsr__id = "dsr01"
DR_init.__dsr__model = "m0609"
rclpy.init()
node = rclpy.create_node("moves", namespace="dsr01")
DR_init.__dsr__node = node
"""
MOTIONS = (
    BEGIN
    + """
from DSR_ROBOT2 import (
    DR_MV_MOD_REL, amovel, check_motion, get_current_posj, get_current_posx, movec, movej, movel,
    movesj, mwait, set_accj, set_accx, set_velj, set_velx)
from DR_common2 import posj, posx

home = posj(0, 0, 90, 0, 90, 0)
codes = [movej(home, vel=60, acc=60)]
there = get_current_posj()
set_velj(60); set_accj(100); set_velx(250, 80); set_accx(1000, 300)
codes.append(movej([10, 0, 90, 0, 90, 0]))
codes.append(movej(home, v=30, a=60, t=2.0))
before, solution = get_current_posx()
codes.append(movel(posx(0, 0, -50, 0, 0, 0), vel=100, acc=200, mod=DR_MV_MOD_REL))
after, _ = get_current_posx()
codes.append(amovel(before))
moving = check_motion()
mwait()
resting = check_motion()
over = [before[0], before[1] + 30, before[2] - 30, *before[3:]]
end = [before[0], before[1], before[2] - 60, *before[3:]]
codes.append(movec(posx(over), posx(end)))
codes.append(movesj([posj(5, 0, 90, 0, 90, 0), home]))
"""
)
PICK = (
    BEGIN
    + """
from DSR_ROBOT2 import *

ON_PIN = 1

def grip():
    set_digital_output(ON_PIN, ON)
    set_digital_output(-2)
    wait(0.5)

set_robot_mode(ROBOT_MODE_AUTONOMOUS)
set_tool("Tool Weight")
set_tcp("GripperDA_v1")
mode, tool, tcp = get_robot_mode(), get_tool(), get_tcp()
movej(posj([0, 0, 90, 0, 90, 0]), vel=60, acc=60)
grip()
pins = get_digital_output(1), get_digital_output(2), get_digital_input(1)
codes = [task_compliance_ctrl([500, 500, 500, 100, 100, 100]),
         set_desired_force(fd=[0, 0, -20, 0, 0, 0], dir=[0, 0, 1, 0, 0, 0], mod=DR_FC_MOD_REL)]
turns = 0
while not check_force_condition(DR_AXIS_Z, max=5):
    turns += 1
codes += [release_force(), release_compliance_ctrl()]
first = fkin([0, 0, 90, 0, 90, 0], DR_BASE)
back = ikin(posx(list(first)), 2)
"""
)
WAITS = (
    BEGIN
    + """
from DSR_ROBOT2 import *

def wait_for(index, value):
    asked = 0
    while get_digital_input(index) != value:
        asked += 1
        wait(0.5)
    return asked

waited = [wait_for(1, ON), wait_for(1, OFF)]
"""
)
WRONG = (
    BEGIN
    + """
from DSR_ROBOT2 import DR_Error, movej, movel, posj, set_velx

ended = []

def refused(call):
    try:
        call()
    except DR_Error as error:
        ended.append(not rclpy.ok())
        rclpy.init()
        return error.type, str(error)

wrong = [
    refused(lambda: movej((0, 0, 90, 0, 90, 0), vel=60, acc=60)),
    refused(lambda: movej(posj(0, 0, 90, 0, 90, 0))),
    refused(lambda: movej(posj(0, 0, 90, 0, 90, 0), vel="60", acc=60)),
    refused(lambda: movel([1, 2, 3], vel=60, acc=60)),
    refused(lambda: set_velx(-1)),
]
"""
)


def test_an_input_that_a_program_waits_for_is_assumed_to_change(run_dsr):
    ran = run_dsr(WAITS)
    assert all(10 <= asked <= 12 for asked in ran["waited"])
    found = [each.message for each in ran.recording.findings if each.kind == "answer_assumed"]
    assert "ctrl_box_digital_input 1 is asked for again and again" in found[0]
    assert "assumed to become 1" in found[0]


@pytest.fixture
def run_dsr(tmp_path: Path) -> Any:
    def run(text: str) -> Ran:
        script = tmp_path / "program.py"
        script.write_text(text)
        interfaces = Interfaces2()
        ran = run_traced(script, interfaces, robot="m1013", scene="empty", duration_s=60.0)
        return quiet_end(*ran)

    return run


def test_arms_move_by_joints_along_lines_and_over_circles(run_dsr):
    ran = run_dsr(MOTIONS)
    assert ran["codes"] == [0] * 7
    assert list(ran["there"]) == pytest.approx([0, 0, 90, 0, 90, 0], abs=0.1)
    before, after = ran["before"], ran["after"]
    assert after[2] - before[2] == pytest.approx(-50, abs=1.0)
    assert (ran["moving"], ran["resting"]) == (2, 0)
    assert ran["solution"] in range(8)
    assert [each.end for each in ran.recording.commands] == ["arrived"] * 7
    assert str(ran["home"]) == "[0.000, 0.000, 90.000, 0.000, 90.000, 0.000]"


@pytest.mark.slow
def test_a_pick_switches_pins_and_does_not_wait_for_a_force_that_is_not_simulated(run_dsr):
    ran = run_dsr(PICK)
    assert (ran["mode"], ran["tool"], ran["tcp"]) == (1, "Tool Weight", "GripperDA_v1")
    assert ran["pins"] == (1, 0, 0)
    assert ran["codes"] == [-1, -1, 0, 0]
    assert ran["turns"] == 0
    found = " ".join(each.message for each in ran.recording.findings)
    assert "check_force_condition: not simulated" in found
    assert "tool centre point 'GripperDA_v1' is not created by the controller" in found
    assert list(ran["back"]) == pytest.approx([0, 0, 90, 0, 90, 0], abs=0.5)


def test_wrong_arguments_raise_the_librarys_error_and_shut_down_rclpy(run_dsr):
    ran = run_dsr(WRONG)
    assert ran["wrong"] == [
        (1000, "Invalid type : pos"),
        (1001, "Invalid value : vel, v (0.0, when time = 0.0)"),
        (1000, "Invalid type : vel, v"),
        (1000, "Invalid type : pos"),
        (1001, "Invalid value : vel"),
    ]
    assert ran["ended"] == [True] * 5
