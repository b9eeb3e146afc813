"""What the simulation logs of contacts: a pressed finger, declared bodies, an arm in itself."""

from pathlib import Path

import numpy as np
import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.physics.motion import JointTrajectory, Pose
from tracerisk.twin.physics.scene import Scene, load_scene
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.recording.contact_log import ContactLog, LoggedBody, read_contacts
from tracerisk.twin.recording.contact_pairs import PairTouches, pair_touches
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.simulation.twin import Twin

FOLDED = (0.0, 0.5, 0.0, -3.0, 0.0, 1.0, 0.785)
UNTURNED = (0.0, 0.0, 0.0, 1.0)
BLOCK = Shape("box", (0.1, 0.1, 0.05))


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module")
def racks() -> Scene:
    return load_scene("tube_racks")


def fold(panda: Robot) -> JointTrajectory:
    """A straight way to a posture in which the hand is within the shoulder."""
    joints = tuple(joint.name for joint in panda.arm_joints)
    begin = [panda.initial_state[name] for name in joints]
    at_rest = np.zeros((2, len(joints)))
    return JointTrajectory(joints, np.array([0.0, 1.5]), np.array([begin, FOLDED]), at_rest)


def logged(folder: Path) -> tuple[ContactLog, dict[tuple[str, str], PairTouches]]:
    log = read_contacts(folder, read_samples(folder).n_steps)
    found = {}
    for pair in pair_touches(log, read_samples(folder).n_steps):
        found[log.bodies[pair.one].name, log.bodies[pair.two].name] = pair
    return log, found


def test_things_that_rest_are_not_looked_at(panda: Robot, racks: Scene, tmp_path: Path):
    with SampleWriter(tmp_path) as writer:
        Twin.build(panda, racks, samples=writer).advance(1_000_000_000)
    log, _ = logged(tmp_path)
    assert len(log.rows) == 0
    assert LoggedBody("tube_1", "free", 0.025) in log.bodies
    assert LoggedBody("table", "fixed") in log.bodies
    assert {body.name for body in log.bodies if body.kind == "link"} == set(panda.link_names)


def test_a_block_on_the_hand_is_logged_with_its_weight_and_under_its_name(
    panda: Robot, racks: Scene, tmp_path: Path
):
    """A free body of 2 kg that is spawned above the arm falls on it; then another model runs."""
    with SampleWriter(tmp_path) as writer:
        twin = Twin.build(panda, racks, samples=writer)
        twin.advance(100_000_000)
        flange = twin.link_pose("panda_hand").position
        above = Pose((flange[0], flange[1], flange[2] + 0.35), UNTURNED)
        block = SceneBody("block", above, (BLOCK,), is_free=True, given_mass=2.0)
        twin.declare([block])
        twin.advance(600_000_000)
        twin.declare([block, SceneBody("far", Pose((0.0, 1.0, 0.0), UNTURNED), (BLOCK,))])
        twin.advance(800_000_000)
    log, found = logged(tmp_path)
    assert LoggedBody("block", "free", 2.0) in log.bodies
    assert LoggedBody("far", "fixed") in log.bodies
    struck = {pair: each for pair, each in found.items() if "block" in pair}
    assert struck
    assert all(names & set(panda.link_names) for names in map(set, struck))
    greatest = max(float(each.force.max()) for each in struck.values() if each.force is not None)
    assert greatest > 2.0 * 9.81
    assert min(int(each.steps[0]) for each in struck.values()) >= 50, "not before it was there"


def test_an_attached_body_is_a_weld_from_when_to_when(panda: Robot, racks: Scene, tmp_path: Path):
    with SampleWriter(tmp_path) as writer:
        twin = Twin.build(panda, racks, samples=writer)
        twin.advance(100_000_000)
        held = SceneBody(
            "part", Pose((0.0, 0.0, 0.2), UNTURNED), (BLOCK,), link="panda_hand", given_mass=0.3
        )
        twin.declare([held])
        twin.advance(300_000_000)
        twin.declare([])
        twin.advance(400_000_000)
    log, _ = logged(tmp_path)
    (weld,) = log.welds
    assert log.bodies[weld.body] == LoggedBody("part", "free", 0.3)
    assert (weld.link, weld.start, weld.stop) == ("panda_hand", 50, 150)


def test_an_arm_that_folds_into_itself_is_logged_as_overlap(
    panda: Robot, racks: Scene, tmp_path: Path
):
    with SampleWriter(tmp_path) as writer:
        twin = Twin.build(panda, racks, samples=writer)
        twin.advance(20_000_000)
        twin.follow(fold(panda))
        twin.advance(2_500_000_000)
        twin.advance(2_500_000_000)
        expected = {frozenset(pair) for pair in twin.collisions()}
    _, found = logged(tmp_path)
    own = {frozenset(pair): each for pair, each in found.items() if each.force is None}
    assert expected
    assert set(own) >= expected
    assert all(int(each.steps[0]) > 50 for each in own.values()), "it did not begin so"
