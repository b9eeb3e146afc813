"""Doosan's library DSR_ROBOT of ROS 1 as programs use it, on the controller that the twin serves."""

from pathlib import Path
from typing import Any

import pytest

from tests.ran import Ran
from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces

BEGIN = """
import rospy
import DR_init

DR_init.__dsr__id = "dsr01"
DR_init.__dsr__model = "m1013"
from DSR_ROBOT import *

rospy.init_node("moves")
"""
MOTIONS = (
    BEGIN
    + """
codes = [set_robot_mode(ROBOT_MODE_AUTONOMOUS)]
home = posj(0, 0, 90, 0, 90, 0)
codes.append(movej(home, vel=60, acc=60))
there = get_current_posj()
before, solution = get_current_posx()
codes.append(movel(posx(0, 0, -50, 0, 0, 0), time=2.0, mod=DR_MV_MOD_REL))
after, _ = get_current_posx()
codes.append(amovel(before, v=100, a=200))
moving = check_motion()
mwait()
codes.append(movesj([posj(5, 0, 90, 0, 90, 0), home], t=3.0))
codes.append(move_spiral(rev=2, rmax=20, lmax=10, time=4.0, axis=DR_AXIS_Z, ref=DR_TOOL))
codes.append(set_digital_output(1, ON))
pins = get_digital_output(1), get_digital_output(2)
"""
)
WRONG = (
    BEGIN
    + """
try:
    movej((0, 0, 90, 0, 90, 0), vel=60, acc=60)
except DR_Error as error:
    wrong = error.type, str(error), rospy.is_shutdown()
"""
)


@pytest.fixture
def run_dsr(tmp_path: Path) -> Any:
    def run(text: str) -> Ran:
        script = tmp_path / "program.py"
        script.write_text(text)
        ran = run_traced(script, Interfaces(), robot="m1013", scene="empty", duration_s=60.0)
        return quiet_end(*ran)

    return run


def test_arms_of_ros1_move_and_switch_pins_below_their_name_and_model(run_dsr):
    ran = run_dsr(MOTIONS)
    assert ran["codes"] == [0] * 7
    assert list(ran["there"]) == pytest.approx([0, 0, 90, 0, 90, 0], abs=0.1)
    assert ran["after"][2] - ran["before"][2] == pytest.approx(-50, abs=1.0)
    assert ran["moving"] == 2
    assert ran["pins"] == (1, 0)
    assert [command.end for command in ran.recording.commands] == ["arrived"] * 5


def test_wrong_arguments_raise_the_librarys_error_and_shut_down_the_node(run_dsr):
    assert run_dsr(WRONG)["wrong"] == (1000, "Invalid type : pos", True)
