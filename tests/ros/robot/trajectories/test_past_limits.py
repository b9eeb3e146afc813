"""Trajectories that lead a joint past its limits on the way, and the finding that says so."""

from pathlib import Path

import pytest

from tests.ros.robot.trajectories.test_too_fast import BY_ACTION, BY_TOPIC, PROGRAM
from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces


@pytest.fixture
def told(tmp_path: Path):
    def told(points, send):
        script = tmp_path / "cell.py"
        script.write_text(PROGRAM.replace("POINTS", repr(points)) + send, encoding="utf-8")
        ran = quiet_end(*run_traced(script, Interfaces(), scene="empty", duration_s=30.0))
        return [each for each in ran.recording.findings if each.kind == "past_limit"]

    return told


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("send", [BY_ACTION, BY_TOPIC])
def test_a_point_on_the_way_past_a_limit_is_told_of(told, send):
    (finding,) = told([(2.0, 0.3), (6.0, 3.2), (9.0, 0.0)], send)
    assert finding.object == "panda_joint1"
    assert "on its way to 3.2, past its limits [-2.8973, 2.8973]" in finding.message
    assert finding.location.line > 9


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("points", [[(2.0, 0.3), (6.0, 3.2)], [(4.0, 2.89), (8.0, 0.0)]])
def test_a_goal_past_it_is_its_commands_matter_and_one_within_is_none(told, points):
    assert not told(points, BY_ACTION)
