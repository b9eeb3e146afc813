"""Which poses are written of what moves, rests, and creeps on."""

import numpy as np
import pytest

from tracerisk.pipeline.recordings.writing.markers import _RESTS, _moved


def one_by_one(last, poses):
    kept = []
    for index, now in enumerate(poses):
        if np.abs(now - last).max() > _RESTS:
            kept.append(index)
            last = now
    return kept


@pytest.mark.parametrize("rest", [0.0, 0.5, 0.8])
@pytest.mark.parametrize("step", [0.1, 0.4, 3.0])
def test_a_pose_is_written_once_it_is_elsewhere_than_the_last_one_written(step, rest):
    random = np.random.default_rng(1)
    steps = random.normal(scale=step * _RESTS, size=(1000, 2, 7))
    steps[random.random(1000) < rest] = 0.0
    poses = np.cumsum(steps, axis=0)
    kept = _moved(poses[0], poses[1:])
    assert kept == one_by_one(poses[0], poses[1:])
    assert kept


def test_of_no_things_and_at_no_time_nothing_is_written():
    assert _moved(np.zeros((0, 7)), np.zeros((5, 0, 7))) == []
    assert _moved(np.zeros((2, 7)), np.zeros((0, 2, 7))) == []
