"""Where a drafted pose is moved to, and what of an entry moves with it."""

import pytest

from tracerisk.ros.drafts.shifted_poses import reachable_shift, shifted

PLACE = (0.4, 0.0, 0.3)


def test_the_least_shift_that_helps_is_taken():
    assert reachable_shift(PLACE, lambda by: 0.3 + by[2] < 0.21) == (0.0, 0.0, -0.1)
    assert reachable_shift(PLACE, lambda by: by[0] < -0.07) == pytest.approx((-0.08, 0.0, 0.0))


def test_nothing_is_moved_below_the_floor_of_the_base_or_where_nothing_helps():
    assert reachable_shift((0.4, 0.0, 0.03), lambda by: by[2] < 0) is None
    assert reachable_shift(PLACE, lambda by: False) is None


def test_positions_near_the_place_move_and_nothing_else():
    pose = {
        "position": {"x": 0.4, "y": 0.0, "z": 0.1},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    }
    entry = {"pose": pose, "twist": {"linear": {"x": 0.1, "y": 0.0, "z": 0.0}}, "count": 3}
    moved = shifted(entry, PLACE, (-0.1, 0.0, 0.05))
    assert moved["pose"]["position"] == {"x": 0.3, "y": 0.0, "z": 0.15}
    assert moved == {**entry, "pose": {**pose, "position": moved["pose"]["position"]}}


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ({"name": "part", "xyz": [0.4, 0.0, 0.1]}, [0.3, 0.0, 0.1]),
        ({"name": "part", "xyz": [0.4, 0.0, 0.1], "attached": "hand"}, [0.4, 0.0, 0.1]),
        ({"frame": "base_link", "xyz": [0.0, 0.0, 0.0]}, [0.0, 0.0, 0.0]),
        ({"name": "tray", "xyz": [-0.4, 0.0, 0.1]}, [-0.4, 0.0, 0.1]),
    ],
)
def test_what_is_held_or_far_or_the_base_stays(entry, expected):
    assert shifted(entry, PLACE, (-0.1, 0.0, 0.0))["xyz"] == expected
