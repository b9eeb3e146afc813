"""Trajectories that a joint cannot follow in their time, and the finding that says so."""

from functools import partial

import pytest

from tracerisk.common.traced.findings import NOTES


@pytest.fixture
def told(reported):
    return partial(reported, "too_fast")


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("send", ["action", "topic"])
@pytest.mark.parametrize(
    "points", [[(0.2, 1.5)], [(2.0, 0.3), (2.15, 1.2)], [(1.0, 0.5), (1.1, 0.0), (3.0, 0.0)]]
)
def test_a_way_that_a_joint_cannot_follow_is_told_of(told, points, send):
    (finding,) = told(points, send)
    assert finding.object == "panda_joint1"
    assert "and its limit 2.17 rad/s" in finding.message
    assert finding.location.line > 9
    assert finding.kind in NOTES


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("send", ["action", "topic"])
@pytest.mark.parametrize("points", [[(2.0, 1.5)], [(0.5, 0.9)], [(0.04, 0.3)]])
def test_one_that_it_can_or_that_a_stream_may_have_is_not(told, points, send):
    assert not told(points, send)
