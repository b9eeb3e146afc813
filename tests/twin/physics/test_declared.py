"""Declared bodies: planned around, touched, carried, and told where a run cannot be replayed."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import LogError, RobotError
from tracerisk.twin.physics.motion import PlanningError, Pose
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.physics.scene_body import HalfSpace, Hull, SceneBody
from tracerisk.twin.recording.replay import replay
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.simulation.twin import Twin

SECOND = 1_000_000_000
NO_TURN = (0.0, 0.0, 0.0, 1.0)
CUBE = (Shape("box", (0.02, 0.02, 0.02)),)
POST = SceneBody("post", Pose((0.45, 0.0, 0.4), NO_TURN), (Shape("box", (0.05, 0.05, 0.4)),))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("panda")


@pytest.fixture
def twin(robot: Robot) -> Twin:
    return Twin.build(robot, load_scene("empty"))


def _finish(twin: Twin, motion) -> None:
    while motion.outcome == "active":
        twin.advance(twin.time_ns + SECOND)
    assert motion.outcome == "succeeded", motion.message


def _swing(twin: Twin, angle: float) -> None:
    plan = twin.plan_joints("panda_arm", {"panda_joint1": angle}, scaling=Scaling(1.0, 1.0))
    _finish(twin, twin.follow(plan))


def test_the_way_around_is_free_and_the_same_each_time(robot: Robot, twin: Twin):
    start = {**robot.initial_state, "panda_joint1": -1.0}
    straight = twin.plan_joints("panda_arm", {"panda_joint1": 1.0}, start=start)
    assert np.ptp(straight.position[:, 1:], axis=0) == pytest.approx(np.zeros(6))
    twin.declare([POST])
    around = twin.plan_joints("panda_arm", {"panda_joint1": 1.0}, start=start)
    again = twin.plan_joints("panda_arm", {"panda_joint1": 1.0}, start=start)
    assert around.position.tobytes() == again.position.tobytes()
    for row in around.position:
        assert twin.collision({**start, **dict(zip(around.joints, row, strict=True))}) is None
    (post,) = POST.shapes
    wider = replace(post, size=tuple(half + 4e-3 for half in post.size))
    twin.declare([replace(POST, shapes=(wider,))])
    for before, after in pairwise(around.position):
        for row in np.linspace(before, after, 5):  # it does not rub on the post between them
            assert twin.collision({**start, **dict(zip(around.joints, row, strict=True))}) is None
    twin.declare([POST], [frozenset(("post",))])
    allowed = twin.plan_joints("panda_arm", {"panda_joint1": 1.0}, start=start)
    assert allowed.position.tobytes() == straight.position.tobytes()


@pytest.mark.parametrize(
    ("begin", "end", "failure"), [(-1.0, 0.0, "collision"), (0.0, 1.0, "start_in_collision")]
)
def test_an_end_in_collision_is_reported(robot: Robot, twin: Twin, begin, end, failure):
    twin.declare([POST])
    start = {**robot.initial_state, "panda_joint1": begin}
    with pytest.raises(PlanningError, match=r"touches 'post'|'post' touches") as reported:
        twin.plan_joints("panda_arm", {"panda_joint1": end}, start=start)
    assert reported.value.failure == failure


def test_a_held_cube_goes_with_the_hand_and_stays_where_it_is_left(twin: Twin):
    _finish(twin, twin.move_gripper("panda_hand", 0.04))
    tip = twin.link_pose("panda_hand_tcp")
    twin.declare([SceneBody("cube", tip, CUBE)])
    grasp = twin.move_gripper("panda_hand", 0.0)
    _finish(twin, grasp)
    assert grasp.stalled, "the fingers stop on the cube"
    here = Pose((0.0, 0.0, 0.0), NO_TURN)
    fingers = ("panda_leftfinger", "panda_rightfinger")
    twin.declare([SceneBody("cube", here, CUBE, link="panda_hand_tcp", touch_links=fingers)])
    _swing(twin, 0.6)
    there = twin.object_pose("cube")
    assert there.position == pytest.approx(twin.link_pose("panda_hand_tcp").position, abs=1e-3)
    assert there.position[1] > 0.15
    twin.declare([SceneBody("cube", there, CUBE)])
    _finish(twin, twin.move_gripper("panda_hand", 0.04))
    assert twin.object_pose("cube").position == pytest.approx(there.position)
    twin.declare([])
    twin.advance(twin.time_ns + SECOND // 10)
    with pytest.raises(RobotError, match="no object 'cube'"):
        twin.object_pose("cube")


def test_a_body_declared_where_an_object_stands_is_that_object(robot: Robot):
    twin = Twin.build(robot, load_scene("tube_racks"))
    tube = twin.scene.objects[0]
    at = twin.object_pose(tube.name)
    x, y, z = (a - b for a, b in zip(at.position, twin.scene.robot_xyz, strict=True))
    twin.declare([SceneBody("sample", Pose((x, y, z), NO_TURN), tube.shapes)])
    twin.advance(SECOND // 5)
    assert twin.object_pose("sample") == twin.object_pose(tube.name)
    assert twin.object_pose(tube.name).position == pytest.approx(at.position, abs=2e-3)


def test_state_goes_on_unchanged_when_a_body_far_away_is_declared(robot: Robot):
    def swung(bodies: list[SceneBody]) -> np.ndarray:
        twin = Twin.build(robot, load_scene("empty"))
        plan = twin.plan_joints("panda_arm", {"panda_joint1": 0.5}, scaling=Scaling(1.0, 0.1))
        twin.follow(plan)
        twin.advance(SECOND // 2)
        twin.declare(bodies)
        twin.advance(SECOND)
        return np.array(twin.joint_state().position)

    far = SceneBody("far", Pose((3.0, 0.0, 0.5), NO_TURN), CUBE)
    assert swung([far]) == pytest.approx(swung([]), abs=1e-6)


def test_replay_says_that_it_cannot_follow_declared_bodies(robot: Robot, tmp_path: Path):
    scene = load_scene("empty")
    for bodies in ([], [POST]):
        twin = Twin.build(robot, scene, samples=SampleWriter(tmp_path))
        twin.declare(bodies)
        twin.advance(SECOND // 10)
        twin.close()
        samples = read_samples(tmp_path)
        assert samples.poses.shape[1] == samples.header.n_pose
        if not bodies:
            assert replay(samples, robot, scene).same_end
        else:
            with pytest.raises(LogError, match="put objects of its planning scene"):
                replay(samples, robot, scene)


def test_what_is_no_body_is_refused():
    flat = Hull(tuple((float(x), float(y), 0.0) for x in (0, 1) for y in (0, 1)))
    with pytest.raises(RobotError, match="a mesh of scene object 'sheet' has no volume"):
        SceneBody("sheet", Pose((0.0, 0.0, 0.0), NO_TURN), hulls=(flat,))
    ground = HalfSpace(Pose((0.0, 0.0, 0.0), NO_TURN))
    with pytest.raises(RobotError, match="is a plane and cannot be attached to 'panda_hand'"):
        SceneBody("floor", Pose((0.0, 0.0, 0.0), NO_TURN), half_spaces=(ground,), link="panda_hand")
