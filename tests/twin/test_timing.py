from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.twin.timing import along_path, resample, straight_line

VELOCITY = np.array([2.0, 1.0, 0.5])
ACCELERATION = np.array([3.0, 2.0, 4.0])
STEP = 0.0005
positions = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)


def assert_within_limits(time, position, velocity, slack: float) -> None:
    path, speed = resample(time, position, velocity, STEP)
    assert (np.abs(speed) <= VELOCITY * (1 + slack) + 1e-9).all()
    path = np.vstack((position[:1], path))
    speed = np.vstack((velocity[:1], speed))
    assert (np.abs(np.diff(speed, axis=0)) / STEP <= ACCELERATION * (1 + slack) + 1e-6).all()
    # The velocities are those of the positions.
    assert np.diff(path, axis=0) / STEP == pytest.approx(
        (speed[1:] + speed[:-1]) / 2, abs=ACCELERATION.max() * STEP
    )


@settings(deadline=None)
@given(positions, positions)
def test_a_straight_line_keeps_the_limits_and_rests_at_both_ends(start, goal):
    time, position, velocity = straight_line(start, goal, VELOCITY, ACCELERATION)
    assert position[0] == pytest.approx(start, abs=1e-9)
    assert position[-1].tolist() == goal.tolist()
    assert velocity[0].tolist() == velocity[-1].tolist() == [0.0, 0.0, 0.0]
    if len(time) > 1:
        assert_within_limits(time, position, velocity, slack=0.05)


def test_a_long_line_cruises_at_the_limit_of_its_slowest_joint():
    start, goal = np.zeros(3), np.array([1.0, 3.0, 0.1])
    time, _, velocity = straight_line(start, goal, VELOCITY, ACCELERATION)
    assert velocity.max(axis=0)[1] == pytest.approx(1.0)
    # Ramps to v last 1.5 v / a each and cover half of it: 3 m take 3 / 1 + 1.5 * 1 / 2 s.
    assert time[-1] == pytest.approx(3.0 + 0.75)


def test_no_way_takes_no_time():
    time, position, _ = straight_line(np.ones(3), np.ones(3), VELOCITY, ACCELERATION)
    assert (time.tolist(), position.tolist()) == ([0.0], [[1.0, 1.0, 1.0]])


def test_a_curved_path_keeps_the_limits_and_rests_at_both_ends():
    u = np.linspace(0.0, 1.0, 60)[:, None]
    path = np.hstack((np.sin(2 * u), u**2, np.cos(u)))
    time, position, velocity = along_path(path, VELOCITY, ACCELERATION)
    assert position.tolist() == path.tolist()
    assert velocity[0].tolist() == velocity[-1].tolist() == [0.0, 0.0, 0.0]
    assert (np.abs(velocity) <= VELOCITY * (1 + 1e-6)).all()
    mean_acceleration = np.diff(velocity, axis=0) / np.diff(time)[:, None]
    assert (np.abs(mean_acceleration) <= ACCELERATION * 1.1).all()


def test_a_path_is_timed_nearly_as_fast_as_its_limits_allow():
    path = np.linspace(0.0, 1.0, 101)[:, None] * np.array([1.0, 0.0, 0.0])
    time, _, _ = along_path(path, VELOCITY, ACCELERATION)
    # At 3 rad/s^2 up to 2 rad/s and down again the limit of speed is not met: 2 sqrt(1 / 3) s.
    assert time[-1] == pytest.approx(2 * np.sqrt(1 / 3), rel=0.05)


def test_points_that_repeat_are_dropped():
    path = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.2, 0.0]])
    time, position, _ = along_path(path, VELOCITY, ACCELERATION)
    assert len(position) == 3
    assert (np.diff(time) > 0).all()


def test_samples_end_at_the_last_point():
    time = np.array([0.0, 0.0105])
    position = np.array([[0.0], [1.0]])
    path, speed = resample(time, position, np.zeros((2, 1)), 0.002)
    assert len(path) == 6
    assert (path[-1, 0], speed[-1, 0]) == (1.0, 0.0)


def test_a_very_slow_line_is_no_larger_than_others():
    start, goal = np.zeros(3), np.ones(3)
    time, position, velocity = straight_line(start, goal, VELOCITY * 1e-6, ACCELERATION * 1e-6)
    assert time[-1] > 1e6
    assert len(position) <= 2001
    assert velocity.max() == pytest.approx(0.5e-6, rel=1e-3)
