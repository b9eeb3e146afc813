"""When a joint moves, for crafted speeds and set-points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.twin.recording.joint_motion import (
    LEVER_M,
    SetPoint,
    _windowed_most,
    distinct,
    motion_steps,
    runs,
)

STEP = 0.002


def found(position: np.ndarray, value: np.ndarray | None = None, unit: float = 1.0):
    """The (start, stop) of each motion [s] of a joint at positions, behind a set-point or none."""
    velocity = np.diff(position, prepend=position[:1]) / STEP
    set_point = None if value is None else SetPoint(value, position, 0.1)
    moving, _ = motion_steps(velocity, set_point, unit, STEP)
    return [(a * STEP, b * STEP) for a, b in zip(*(x.tolist() for x in runs(moving)), strict=True)]


def path(*points: tuple[float, float]) -> np.ndarray:
    """A position that goes straight from point to point (time, position)."""
    times, positions = zip(*points, strict=True)
    return np.interp(np.arange(round(times[-1] / STEP)) * STEP, times, positions)


def test_a_vibration_of_a_held_arm_is_no_motion():
    time = np.arange(5000) * STEP
    assert found(2e-3 * np.sin(2 * np.pi * 12 * time)) == []


def test_a_large_swing_is_one_motion():
    time = np.arange(5000) * STEP
    (span,) = found(0.2 * np.sin(2 * np.pi * 2 * time))
    assert span == pytest.approx((0.0, 10.0), abs=0.05)


def test_the_tail_of_a_servo_is_no_motion():
    time = np.arange(2500) * STEP
    value = np.clip((time - 1.0) * 0.5, 0.0, 0.5)
    # The joint follows without lag, then runs on by 2 mrad and creeps back.
    position = value + np.where(time > 2.0, 2e-3 * np.exp(-(time - 2.0) / 0.1), 0.0)
    ((start, stop),) = found(position, value)
    assert (start, stop) == pytest.approx((1.0, 2.0), abs=0.02)


def test_a_joint_that_is_held_fast_does_not_move_with_its_set_point():
    value = path((0, 0), (1, 0), (2, 0.4), (4, 0.4))
    assert found(np.zeros(len(value)), value) == []


def test_a_motion_ends_where_the_joint_is_stopped():
    value = path((0, 0), (1, 0), (2, 0.4), (4, 0.4))
    ((start, stop),) = found(np.minimum(value, 0.2), value)
    assert start == pytest.approx(1.0, abs=0.005)
    assert stop == pytest.approx(1.5, abs=0.03)


def test_a_set_point_that_trembles_after_a_motion_does_not_prolong_it():
    value = path((0, 0), (1, 0), (2, 0.4), (8, 0.4))
    value[1000:] += 3e-5 * np.sin(np.arange(len(value) - 1000))
    ((start, stop),) = found(value, value)
    assert (start, stop) == pytest.approx((1.0, 2.0), abs=0.02)


def test_a_set_point_leads_a_motion_however_slow():
    value = path((0, 0), (5, 0), (45, 0.002), (50, 0.002))
    ((start, stop),) = found(value, value)
    assert (start, stop) == pytest.approx((5.0, 45.0), abs=0.01)


def test_a_pause_between_two_motions_is_a_rest():
    value = path((0, 0), (1, 0), (2, 0.4), (2.1, 0.4), (3, 0.8), (4, 0.8))
    assert np.array(found(value, value)) == pytest.approx(
        np.array([(1.0, 2.0), (2.1, 3.0)]), abs=0.005
    )


def test_bounds_of_a_sliding_joint_are_a_tenth():
    value = path((0, 0), (1, 0), (2, 0.0004), (3, 0.0004))
    assert found(value, value) == []
    assert len(found(value, value, LEVER_M)) == 1


@given(
    st.lists(st.tuples(st.floats(0.1, 3.0), st.floats(-0.5, 0.5)), min_size=1, max_size=5),
    st.integers(0, 400),
)
def test_a_later_begin_moves_all_motions_alike(parts: list[tuple[float, float]], shift: int):
    points, time, at = [(0.0, 0.0), (1.0, 0.0)], 1.0, 0.0
    for seconds, far in parts:
        time, at = time + seconds, at + far
        points += [(time, at), (time + 0.3, at)]
        time += 0.3
    value = path(*points)
    before = found(value, value)
    later = np.concatenate((np.zeros(shift), value))
    shifted = [(a + shift * STEP, b + shift * STEP) for a, b in before]
    assert np.array(found(later, later)) == pytest.approx(np.array(shifted))


@given(st.lists(st.floats(-9, 9), min_size=1, max_size=40), st.integers(1, 12))
def test_the_greatest_of_each_window(values: list[float], size: int):
    size = min(size, len(values))
    windows = np.lib.stride_tricks.sliding_window_view(np.array(values), size)
    assert _windowed_most(np.array(values), size).tolist() == windows.max(axis=1).tolist()


@given(st.lists(st.integers(-3, 3)), st.sampled_from([np.int32, np.int64, np.float64]))
def test_distinct_numbers_are_those_of_numpy(values, kind):
    numbers = np.array(values, dtype=kind)
    ours, theirs = distinct(numbers), np.unique(numbers)
    assert (ours.tolist(), ours.dtype) == (theirs.tolist(), theirs.dtype)
    assert distinct(np.stack((numbers, numbers))).tolist() == theirs.tolist()
