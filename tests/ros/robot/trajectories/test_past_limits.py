"""Trajectories that lead a joint past its limits on the way, and the finding that says so."""

from functools import partial

import pytest


@pytest.fixture
def told(reported):
    return partial(reported, "past_limit")


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("send", ["action", "topic"])
def test_a_point_on_the_way_past_a_limit_is_told_of(told, send):
    (finding,) = told([(2.0, 0.3), (6.0, 3.2), (9.0, 0.0)], send)
    assert finding.object == "panda_joint1"
    assert "on its way to 3.2, past its limits [-2.8973, 2.8973]" in finding.message
    assert finding.location.line > 9


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("points", [[(2.0, 0.3), (6.0, 3.2)], [(4.0, 2.89), (8.0, 0.0)]])
def test_a_goal_past_it_is_its_commands_matter_and_one_within_is_none(told, points):
    assert not told(points, "action")
