"""What is kept of a run for its replay, against the run itself."""

import io
import zipfile

import numpy as np
import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import LogError
from tracerisk.twin.physics.declared_log import DeclaredChange, LoggedShape
from tracerisk.twin.recording import packed_run as module
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.packed_run import packed_run, unpacked_run
from tracerisk.twin.recording.samples import POSE_EVERY, until

BALL = LoggedShape("ball", True, (0, 0, 1, 1, 0, 0, 0), (Shape("sphere", (0.02,)),))
WALL = LoggedShape("wall", False, (0, 0, 1, 1, 0, 0, 0), hulls=(((0, 0, 0), (0, 0, 1)),))
DECLARED = (
    DeclaredChange(40, (BALL, WALL), np.array([40.0, 60.0]), np.arange(14.0).reshape(2, 1, 7)),
    DeclaredChange(80, (WALL,), np.empty(0), np.empty((0, 0, 7))),
)


@pytest.fixture(scope="module")
def activity(one_tube):
    return element_activity(one_tube.samples, one_tube.robot)


@pytest.fixture(scope="module")
def packed(one_tube, activity):
    return packed_run(one_tube.samples, one_tube.robot, one_tube.scene, DECLARED, activity)


def test_what_a_replay_shows_comes_back_to_the_bit(one_tube, activity, packed):
    run = unpacked_run(packed, "a.replay")
    assert run.robot == one_tube.robot
    assert run.scene == one_tube.scene
    assert run.samples.header == one_tube.samples.header
    assert run.samples.n_steps == one_tube.samples.n_steps
    frames = one_tube.samples.position[::POSE_EVERY]
    assert np.array_equal(run.samples.position[::POSE_EVERY], frames)
    assert np.array_equal(run.samples.poses, one_tube.samples.poses)
    assert list(run.activity) == list(activity)
    for name, states in activity.items():
        assert run.activity[name].element == states.element
        for state in ("moving", "holding", "grasping", "active"):
            assert np.array_equal(getattr(run.activity[name], state), getattr(states, state))
        assert np.isnan(run.activity[name].speed).all()


def test_declared_bodies_come_back(packed):
    declared = unpacked_run(packed, "a.replay").declared
    assert [(change.step, change.bodies) for change in declared] == [
        (change.step, change.bodies) for change in DECLARED
    ]
    for change, expected in zip(declared, DECLARED, strict=True):
        assert np.array_equal(change.pose_steps, expected.pose_steps)
        assert np.array_equal(change.poses, expected.poses)


def test_it_is_small_and_the_same_for_the_same_run(one_tube, activity, packed):
    again = packed_run(one_tube.samples, one_tube.robot, one_tube.scene, DECLARED, activity)
    assert again == packed
    samples = one_tube.samples
    assert len(packed) < 0.05 * 8 * samples.header.width * samples.n_steps


def test_activity_is_cut_to_the_samples(one_tube, activity):
    cut = until(one_tube.samples, 3_000_000_000)
    packed = packed_run(cut, one_tube.robot, one_tube.scene, (), activity)
    run = unpacked_run(packed, "a.replay")
    assert {len(states.moving) for states in run.activity.values()} == {1_500}
    assert len(run.samples.poses) == 75


def changed(data: bytes, **arrays) -> bytes:
    with np.load(io.BytesIO(data)) as old:
        stream = io.BytesIO()
        np.savez_compressed(stream, **({name: old[name] for name in old.files} | arrays))
    return stream.getvalue()


def test_what_is_no_packed_run_is_reported(packed):
    text = np.frombuffer(b'{"version": 2}', dtype=np.uint8)
    objects = np.array([{"a": 1}], dtype=object)
    for data, words in (
        (b"", "is no packed run of this version: File is not a zip file"),
        (packed[:-100], "File is not a zip file"),
        (changed(packed, run=text), "version 2"),
        (changed(packed, poses=np.zeros((3, 5))), "the poses are of the shape"),
        (changed(packed, joints=np.zeros((3, 5))), "the joints are of the shape"),
        (changed(packed, states=np.zeros((1, 5), dtype=np.uint8)), "1 rows of states of"),
        (changed(packed, joints=objects), "allow_pickle"),
    ):
        with pytest.raises(LogError, match=words) as caught:
            unpacked_run(data, "a.replay")
        assert str(caught.value).startswith("a.replay: ")


def test_an_archive_that_would_fill_the_memory_is_not_unpacked(packed, monkeypatch):
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        size = sum(part.file_size for part in archive.infolist())
    monkeypatch.setattr(module, "MOST_UNPACKED", size - 1)
    with pytest.raises(LogError, match=f"its arrays take {size} bytes"):
        unpacked_run(packed, "a.replay")
