"""Steps of one stretch, and the same steps looked at in between: the samples are the same."""

from pathlib import Path
from typing import Any

import pytest

from tests.twin.conftest import Operator
from tracerisk.errors import RobotError
from tracerisk.twin.physics.physics import divergence
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import POSE_EVERY, SampleWriter, read_samples
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

# After the twin, which says that no window is needed.
import mujoco  # isort: skip

FILES = ("samples.bin", "poses.bin", "contacts.bin", "contact_bodies.jsonl", "end_pose.bin")


def carried(folder: Path, *, is_watched: bool) -> list[int]:
    """Carry a tube to the other rack; return the steps at which a chunk began."""
    folder.mkdir()
    begun: list[int] = []
    with SampleWriter(folder) as writer:
        twin = Twin.build(load_robot("panda"), load_scene("tube_racks"), samples=writer)
        if is_watched:
            twin.watch_touches(lambda *_: None)
        twin.before_chunk = lambda now_ns: begun.append(now_ns // twin.step_ns)
        Operator(twin).move_tube(1)
        twin.advance(twin.time_ns + 500_000_000)
        twin.close()
    return begun


def test_a_look_in_between_changes_no_bit(tmp_path: Path) -> None:
    whole = carried(tmp_path / "whole", is_watched=False)
    cut = carried(tmp_path / "cut", is_watched=True)
    assert len(whole) < len(cut) / 4
    for name in FILES:
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "cut" / name).read_bytes()
    samples = read_samples(tmp_path / "whole")
    assert samples.contacts is not None
    assert len(samples.contacts.rows) > 100
    assert len(samples.poses) == -(-samples.n_steps // POSE_EVERY)


def test_a_stretch_that_is_broken_off_keeps_the_time_of_each_sample(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = [2 * POSE_EVERY + 5]

    def step(model: Any, data: Any) -> None:
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        real(model, data)

    real = mujoco.mj_step
    with SampleWriter(tmp_path) as writer:
        twin = Twin.build(load_robot("panda"), load_scene("tube_racks"), samples=writer)
        monkeypatch.setattr(mujoco, "mj_step", step)
        with pytest.raises(KeyboardInterrupt):
            twin.advance(500_000_000)
        assert twin.time_ns == 2 * POSE_EVERY * twin.step_ns
        monkeypatch.setattr(mujoco, "mj_step", real)
        twin.advance(500_000_000)
        assert read_samples(tmp_path).n_steps * twin.step_ns == twin.time_ns


def test_a_simulation_that_is_unstable_remains_so(tmp_path: Path) -> None:
    with SampleWriter(tmp_path) as writer:
        twin = Twin.build(load_robot("panda"), load_scene("tube_racks"), samples=writer)
        divergence(twin._simulation._data)[0] = 1
        for _ in range(2):
            with pytest.raises(RobotError, match=r"became unstable at 0\.000 s"):
                twin.advance(500_000_000)
    assert read_samples(tmp_path).n_steps == 0
