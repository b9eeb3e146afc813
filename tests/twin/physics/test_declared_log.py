"""What is logged of declared bodies, against where the simulation has them."""

from pathlib import Path

import numpy as np
import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import LogError
from tracerisk.twin.physics.declared_log import DeclaredLogWriter, LoggedShape, read_declared
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.physics.scene_body import HalfSpace, Hull, SceneBody
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

NO_TURN = (0.0, 0.0, 0.0, 1.0)
CUBE = (Shape("box", (0.02, 0.02, 0.02)),)
MS = 1_000_000


def pose_of(twin, name):
    pose = twin.object_pose(name)
    x, y, z, w = pose.orientation
    return np.array([*pose.position, w, x, y, z])


def test_bodies_are_logged_where_they_are(tmp_path: Path):
    corners = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
    post = SceneBody("post", Pose((0.6, 0.3, 0.2), NO_TURN), CUBE, (Hull(corners),))
    ground = SceneBody(
        "ground",
        Pose((0.0, 0.0, -0.5), NO_TURN),
        half_spaces=(HalfSpace(Pose((0.0, 0.0, 0.0), NO_TURN)),),
    )
    ball = SceneBody("ball", Pose((0.5, -0.3, 0.8), NO_TURN), CUBE, is_free=True)
    seen = {}
    with SampleWriter(tmp_path) as samples:
        scene = load_scene("empty")
        twin = Twin.build(load_robot("panda"), scene, samples=samples)
        twin.advance(50 * MS)
        twin.declare([post, ball])
        while twin.time_ns < 200 * MS:
            twin.advance(twin.time_ns + 2 * MS)
            seen[twin.time_ns // (2 * MS)] = pose_of(twin, "ball")
        held = SceneBody("tool", Pose((0.0, 0.0, 0.1), NO_TURN), CUBE, link="panda_hand")
        twin.declare([ground, held])
        twin.advance(300 * MS)
        tool = pose_of(twin, "tool")
        twin.declare([])
        twin.advance(340 * MS)
        twin.close()
    first, second, third = read_declared(tmp_path)
    assert [each.step for each in (first, second, third)] == [25, 100, 150]
    assert {body.name: body.is_free for body in first.bodies} == {"post": False, "ball": True}
    (logged,) = [body for body in first.bodies if body.name == "post"]
    base = scene.robot_xyz
    assert logged.pose[:3] == pytest.approx(np.add(base, (0.6, 0.3, 0.2)))
    assert (logged.shapes, logged.hulls) == (CUBE, (corners,))
    assert first.pose_steps.tolist() == [40, 60, 80]
    for step, pose in zip(first.pose_steps, first.poses[:, 0], strict=True):
        assert pose == pytest.approx(seen[int(step)], abs=1e-12)
    assert first.poses[0, 0, 2] > first.poses[-1, 0, 2] + 0.01  # it falls
    assert {body.name: len(body.planes) for body in second.bodies} == {"ground": 1, "tool": 0}
    assert second.poses[-1, 0, :3] == pytest.approx(tool[:3], abs=1e-3)
    assert (third.bodies, third.poses.shape) == ((), (0, 0, 7))
    # Nothing of it is among the poses of the scene.
    assert read_samples(tmp_path).poses.shape[1] == 9


def test_a_run_without_declared_bodies_leaves_no_log_and_takes_that_of_another_away(tmp_path):
    log = DeclaredLogWriter(tmp_path)
    log.change(0, [LoggedShape("old", False, (0.0,) * 7)])
    log.close()
    assert len(read_declared(tmp_path)) == 1
    with SampleWriter(tmp_path) as samples:
        twin = Twin.build(load_robot("panda"), load_scene("empty"), samples=samples)
        twin.advance(4 * MS)
    assert read_declared(tmp_path) == ()


def test_a_log_that_was_cut_short_is_read_as_far_as_it_goes(tmp_path: Path):
    log = DeclaredLogWriter(tmp_path)
    log.change(0, [LoggedShape("ball", True, (0.0,) * 7)])
    log.pose(0, np.zeros(7))
    log.pose(20, np.ones(7))
    log.change(30, [])
    log.close()
    lines = tmp_path / "declared.jsonl"
    lines.write_bytes(lines.read_bytes()[:-5])
    poses = tmp_path / "declared_poses.bin"
    poses.write_bytes(poses.read_bytes()[:-9])
    (change,) = read_declared(tmp_path)
    assert change.pose_steps.tolist() == [0]


def test_a_damaged_log_is_reported(tmp_path: Path):
    DeclaredLogWriter(tmp_path).close()
    (tmp_path / "declared.jsonl").write_text('{"step": 0}\n')
    with pytest.raises(LogError, match=r"declared\.jsonl: is no log of declared bodies"):
        read_declared(tmp_path)
