"""What collides with what: the pairs that an SRDF disables, and plans clear of the arm itself."""

from dataclasses import replace

import numpy as np
import pytest

from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.physics.collision import CollisionWorld
from tracerisk.twin.robots.robot import load_robot


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
