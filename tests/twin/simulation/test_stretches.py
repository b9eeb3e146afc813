"""Steps of one stretch, and the same steps looked at in between: the samples are the same."""

from pathlib import Path

from tests.twin.conftest import Operator
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.recording.samples import POSE_EVERY, SampleWriter, read_samples
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

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
