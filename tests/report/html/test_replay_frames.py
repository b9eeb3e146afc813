"""Poses packed and unpacked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from tracerisk.report.html.run.replay_frames import MOST_FRAMES, pack_frames, unpack_frames


@given(
    arrays(
        np.float64,
        array_shapes(min_dims=2, max_dims=2, max_side=12),
        elements=st.floats(-50, 50),
    )
)
def test_what_is_packed_comes_back_to_half_a_quantum(values):
    quanta = np.full(values.shape[1], 1e-3)
    frames = pack_frames(values, quanta, 0.04)
    found = unpack_frames(frames)
    assert found.shape == values.shape
    assert np.all(np.abs(found - values) <= np.array(frames.quanta) / 2 + 1e-9)


def test_a_turn_that_goes_on_for_long_needs_no_coarser_quanta():
    values = np.linspace(0.0, 2000.0, 5000)[:, None]
    frames = pack_frames(values, np.array([1e-4]), 0.04)
    assert frames.quanta == (1e-4,)
    assert np.abs(unpack_frames(frames) - values).max() <= 0.5e-4 + 1e-9


def test_a_jump_too_large_for_the_differences_makes_the_quanta_coarser():
    values = np.array([[0.0], [100.0], [-100.0]])
    frames = pack_frames(values, np.array([1e-4]), 0.04)
    assert 200.0 / 32_767 <= frames.quanta[0] < 0.0062
    assert np.abs(unpack_frames(frames) - values).max() <= frames.quanta[0] / 2


def test_long_runs_are_thinned_out_evenly():
    values = np.arange(2.0 * MOST_FRAMES + 1)[:, None]
    frames = pack_frames(values, np.array([1.0]), 0.04)
    assert frames.count <= MOST_FRAMES
    assert frames.every_s == pytest.approx(0.12)
    assert unpack_frames(frames)[:3, 0].tolist() == [0.0, 3.0, 6.0]


def test_frames_end_before_the_first_that_is_not_finite():
    values = np.array([[0.0], [1.0], [np.nan], [2.0]])
    assert unpack_frames(pack_frames(values, np.array([1.0]), 0.04)).tolist() == [[0.0], [1.0]]


def test_no_frame_at_all_is_packed_as_none():
    frames = pack_frames(np.zeros((0, 3)), np.ones(3), 0.04)
    assert (frames.count, frames.packed) == (0, b"")
    assert unpack_frames(frames).shape == (0, 3)


def test_what_stands_still_costs_next_to_nothing():
    assert len(pack_frames(np.ones((10_000, 70)), np.full(70, 1e-4), 0.04).packed) < 2_000
