"""What stands for links whose shapes no file gives."""

import numpy as np
import pytest

from tracerisk.common.geometry.frames import rotation
from tracerisk.twin.physics.collision import CollisionWorld
from tracerisk.twin.robots.outline import outlined
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.robots.robot_parts import Attachment, Link


def ends(shape):
    reach = rotation(shape.rpy) @ np.array([0.0, 0.0, shape.size[1]])
    return [np.array(shape.xyz) - reach, np.array(shape.xyz) + reach]


def bare(*hung):
    attachments = [
        Attachment(f"joint{i}", kind, "link", f"next{i}", xyz, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        for i, (kind, xyz) in enumerate(hung)
    ]
    return outlined(Link("link", 1.0, (0.0, 0.0, 0.0), None, ()), 0.05, attachments).shapes


def test_a_link_goes_across_to_the_next_axis_and_then_along_it():
    tube, housing = bare(("revolute", (-0.4, 0.0, 0.13)))
    corner = (-0.4, 0.0, 0.0)
    assert ends(tube) == [pytest.approx((0.0, 0.0, 0.0)), pytest.approx(corner)]
    assert ends(housing) == [pytest.approx(corner), pytest.approx((-0.4, 0.0, 0.13))]


@pytest.mark.parametrize(
    ("kind", "xyz"),
    [
        ("revolute", (0.3, 0.2, 0.01)),
        ("revolute", (0.0, 0.01, 0.3)),
        ("fixed", (0.3, 0.0, 0.2)),
    ],
)
def test_a_link_with_next_to_no_corner_is_straight(kind, xyz):
    (only,) = bare((kind, xyz))
    assert ends(only) == [pytest.approx((0.0, 0.0, 0.0)), pytest.approx(xyz)]


def test_a_link_from_which_nothing_leads_away_is_a_ball():
    (only,) = bare(("revolute", (0.0, 0.0, 0.001)))
    assert (only.kind, only.size) == ("sphere", (0.05,))


def test_the_wrist_of_an_arm_turns_freely_beside_its_forearm():
    # The wrist of a UR5e stands 0.13 m beside its forearm, and may turn all around there.
    robot = load_robot("ur5e")
    world = CollisionWorld(robot)
    state = {**robot.initial_state, "elbow_joint": 1.2, "shoulder_lift_joint": -1.2}
    for turn in np.linspace(-np.pi, np.pi, 25):
        found = world.pairs(world.configuration({**state, "wrist_1_joint": float(turn)}))
        assert not [pair for pair in found if "forearm_link" in pair], turn
