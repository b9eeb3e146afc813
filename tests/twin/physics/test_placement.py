"""Where objects ended: at a goal, or astray from one that is free."""

import pytest

from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.placement import offsets
from tracerisk.twin.physics.scene import Goal, GraspableObject

GOALS = (Goal("near", (0.0, 0.0, 0.1)), Goal("far", (1.0, 0.0, 0.1)))


def placed(name: str, x: float) -> tuple[GraspableObject, Pose]:
    thing = GraspableObject(name, (0.0, 0.0, 0.1), (0.0, 0.0, 0.0), 0.1, 1.0, ())
    return thing, Pose((x, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    ("places", "expected"),
    [
        ((0.001, 0.2), [("near", 0.001), ("far", 0.8)]),
        ((0.2, 0.001), [("far", 0.8), ("near", 0.001)]),
        # Nobody stands at a goal: each is astray from the nearest.
        ((0.2, 0.3), [("near", 0.2), ("near", 0.3)]),
        ((0.0, 1.0, 0.4), [("near", 0.0), ("far", 0.0), ("near", 0.4)]),
    ],
)
def test_an_object_astray_is_measured_from_a_goal_that_is_free(places, expected):
    found = offsets([placed(f"part_{n}", x) for n, x in enumerate(places)], GOALS)
    assert [each.goal for each in found] == [name for name, _ in expected]
    assert [each.offset_m for each in found] == pytest.approx([away for _, away in expected])
    assert [each.stands_at_goal for each in found] == [away < 0.003 for _, away in expected]
