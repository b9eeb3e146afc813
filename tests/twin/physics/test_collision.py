"""What collides with what: the pairs that an SRDF disables, and plans clear of the arm itself."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.physics.collision import CollisionWorld
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.robots.robot_reader import read_robot

SHIPPED = Path(__file__).parents[3] / "tracerisk" / "twin" / "robots" / "shipped"


def drawn_pairs(robot, group):
    """Pairs of joint positions of a group, drawn in its limits, always the same ones."""
    joints = [robot.joint(name) for name in robot.groups[group].joints]
    lower = np.array([max(joint.lower, -3.14) for joint in joints])
    upper = np.array([min(joint.upper, 3.14) for joint in joints])
    generator = np.random.default_rng(0)
    while True:
        yield generator.uniform(lower, upper), generator.uniform(lower, upper)


def test_pairs_that_the_srdf_disables_do_not_collide():
    robot = load_robot("fetch")
    names = [joint.name for joint in robot.arm_joints]
    world = CollisionWorld(robot)
    pairs = drawn_pairs(
        replace(robot, groups={"all": replace(robot.groups["arm"], joints=tuple(names))}), "all"
    )
    hits = []
    while len(hits) < 5:
        configuration = world.configuration(dict(zip(names, next(pairs)[0], strict=True)))
        if found := world.pairs(configuration):
            hits.append((configuration, found))
    disabled = frozenset(tuple(sorted(pair)) for _, found in hits for pair in found[:1])
    other = CollisionWorld(replace(robot, disabled_collisions=disabled | {("no_link", "torso")}))
    for configuration, found in hits:
        left = {frozenset(pair) for pair in found} - {frozenset(pair) for pair in disabled}
        assert {frozenset(pair) for pair in other.pairs(configuration)} == left
    # A pair that another robot's SRDF names is no fault of this one.
    assert frozenset(("no_link", "torso")) in other.by_build


@pytest.mark.parametrize(
    ("name", "group"),
    [("fetch", "arm_with_torso"), pytest.param("baxter", "both_arms", marks=pytest.mark.slow)],
)
def test_a_plan_leads_around_the_arm_itself(name, group):
    robot = load_robot(name)
    clearance = Clearance(robot)
    members = [robot.joint(joint) for joint in robot.groups[group].joints]

    def is_free(position):
        names = (joint.name for joint in members)
        return clearance.collision(dict(zip(names, position, strict=True))) is None

    def line(begin, goal):
        return [begin + (goal - begin) * k / 200 for k in range(201)]

    begin, goal = next(
        (begin, goal)
        for begin, goal in drawn_pairs(robot, group)
        if is_free(begin) and is_free(goal) and not all(map(is_free, line(begin, goal)))
    )
    start = {
        **robot.initial_state,
        **dict(zip((joint.name for joint in members), begin, strict=True)),
    }
    way = clearance.way(members, start, begin, [goal])
    assert way is not None
    assert np.array_equal(way[0], begin)
    assert np.array_equal(way[-1], goal)
    assert all(is_free(position) for position in way)
    for position in way:
        for joint, value in zip(members, position, strict=True):
            assert joint.lower - 1e-9 <= value <= joint.upper + 1e-9
    steps = np.abs(np.diff(np.array(way), axis=0)).max()
    assert steps < 0.05, "what lies between two points of the way was looked at"


PANDA_LEANS = (0.0, 0.1, 0.0, -1.57, 0.0, 0.0, 0.0)
"""Where the hand is folded back beside the forearm [rad]."""


def colliding(name, joints, posture):
    """The pairs of links of a shipped robot that collide in a posture [rad]."""
    world = CollisionWorld(load_robot(name))
    return {
        frozenset(pair)
        for pair in world.pairs(world.configuration(dict(zip(joints, posture, strict=True))))
    }


@pytest.mark.parametrize("arm", ["panda", "fr3"])
def test_moveit_does_not_compare_the_hand_of_a_franka_with_its_wrist(arm):
    joints = [f"{arm}_joint{number}" for number in range(1, 8)]
    assert not colliding(arm, joints, PANDA_LEANS)


@pytest.mark.parametrize("arm", ["panda", "fr3"])
def test_moveit_compares_the_hand_of_a_franka_with_its_lower_links(arm):
    joints = [f"{arm}_joint{number}" for number in range(1, 8)]
    folded = colliding(arm, joints, (0.0, 0.53, 0.0, -2.86, 0.0, 1.2, 0.0))
    lower = {f"{arm}_link{number}" for number in range(4)}
    assert any(pair & lower and f"{arm}_hand" in pair for pair in folded)


@pytest.mark.parametrize("arm", ["ur3", "ur5e", "ur30"])
def test_moveit_does_not_compare_the_first_and_the_last_wrist_of_a_ur(arm):
    assert ("wrist_1_link", "wrist_3_link") in load_robot(arm).disabled_collisions
    assert ("shoulder_link", "wrist_1_link") not in load_robot(arm).disabled_collisions


@pytest.mark.parametrize("side", ["left", "right"])
def test_moveit_does_not_compare_the_shoulder_and_the_elbow_of_baxter(side):
    joints = [f"{side}_{name}" for name in ("s0", "s1", "e0", "e1", "w0", "w1", "w2")]
    assert not colliding("baxter", joints, (0.0, 0.9, 0.0, 0.0, 0.0, 0.5, 0.0))


def test_a_pair_of_a_link_that_there_is_not_is_refused(tmp_path):
    text = (SHIPPED / "ur5e.yaml").read_text(encoding="utf-8")
    path = tmp_path / "ur5e.yaml"
    path.write_text(text.replace("wrist_1_link: [wrist_3_link]", "wrist_1_link: [wrist_9_link]"))
    with pytest.raises(RobotError, match="'wrist_9_link'"):
        read_robot(path)
