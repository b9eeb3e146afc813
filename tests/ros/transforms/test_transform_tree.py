"""Lookups among transforms: composition, interpolation, and the four ways to have no answer.

Kinds of errors and their words are those of tf2's buffer_core.cpp and cache.cpp (ros/geometry2).
"""

import math

import pytest

from tracerisk.ros.transforms.poses import ORIGIN, quaternion_from_rpy
from tracerisk.ros.transforms.tree import FrameError, TransformTree
from tracerisk.twin.physics.motion import Pose

S = 1_000_000_000
QUARTER = quaternion_from_rpy(0.0, 0.0, math.pi / 2)


def shifted(x: float = 0.0, y: float = 0.0, z: float = 0.0, turn=ORIGIN.orientation) -> Pose:
    return Pose((x, y, z), turn)


@pytest.fixture
def reported() -> list[str]:
    return []


@pytest.fixture
def tree(reported: list[str]) -> TransformTree:
    """map - base - arm - hand, and map - camera (static); hand moves from 1 s to 3 s."""
    tree = TransformTree(warn=reported.append)
    tree.place("map", "base", shifted(1.0), 0, "test", static=True)
    tree.place("map", "camera", shifted(0.0, 0.0, 2.0), 0, "test", static=True)
    for time_s in (1, 2, 3):
        tree.place("base", "arm", shifted(0.0, time_s), time_s * S, "test", static=False)
        tree.place("arm", "hand", shifted(0.5, turn=QUARTER), time_s * S, "test", static=False)
    return tree


def test_a_way_up_the_tree_is_composed(tree):
    pose, stamp_ns = tree.lookup("map", "hand", 2 * S)
    assert pose.position == pytest.approx((1.5, 2.0, 0.0))
    assert pose.orientation == pytest.approx(QUARTER)
    assert stamp_ns == 2 * S


def test_a_way_down_undoes_the_way_up(tree):
    pose, _ = tree.lookup("hand", "map", 2 * S)
    assert pose.position == pytest.approx((-2.0, 1.5, 0.0))


def test_two_branches_meet_in_their_common_parent(tree):
    pose, _ = tree.lookup("camera", "hand", 3 * S)
    assert pose.position == pytest.approx((1.5, 3.0, -2.0))


def test_time_0_is_the_latest_that_all_of_the_way_knows(tree):
    tree.place("base", "arm", shifted(0.0, 9.0), 4 * S, "test", static=False)
    pose, stamp_ns = tree.lookup("map", "hand", 0)
    assert (stamp_ns, pose.position[1]) == (3 * S, pytest.approx(3.0))
    assert tree.latest_common_time("map", "hand") == 3 * S


def test_a_static_way_has_the_time_0(tree):
    assert tree.lookup("camera", "base", 0)[1] == 0
    assert tree.can_transform("camera", "base", 77 * S) == (True, "")


def test_between_two_poses_is_the_line_and_the_shorter_turn(tree):
    tree.place("hand", "tool", shifted(), 1 * S, "test", static=False)
    tree.place("hand", "tool", shifted(turn=QUARTER), 2 * S, "test", static=False)
    pose, _ = tree.lookup("base", "arm", 1 * S + S // 4)
    assert pose.position == pytest.approx((0.0, 1.25, 0.0))
    pose, _ = tree.lookup("hand", "tool", 1 * S + S // 2)
    assert pose.orientation == pytest.approx(quaternion_from_rpy(0.0, 0.0, math.pi / 4))


def test_a_frame_in_itself_needs_not_exist(tree):
    assert tree.lookup("nowhere", "nowhere", 5 * S) == (ORIGIN, 5 * S)


def test_a_lookup_between_two_times_goes_over_the_fixed_frame(tree):
    pose, stamp_ns = tree.lookup_full("arm", 3 * S, "arm", 1 * S, "map")
    assert pose.position == pytest.approx((0.0, -2.0, 0.0))
    assert stamp_ns == 3 * S
    assert tree.can_transform_full("arm", 3 * S, "arm", 1 * S, "map") == (True, "")


@pytest.mark.parametrize(
    ("target", "source", "time_s", "failure", "message"),
    [
        ("map", "nose", 2, "lookup", '"nose" passed to lookupTransform argument source_frame'),
        ("map", "", 2, "invalid_argument", "frame_ids cannot be empty"),
        ("/map", "hand", 2, "invalid_argument", "frame_ids cannot start with a '/'"),
        (
            "map",
            "hand",
            4,
            "extrapolation",
            "Lookup would require extrapolation 1.000000000s into the future.  Requested time "
            "4.000000000 but the latest data is at time 3.000000000, when looking up transform "
            "from frame [hand] to frame [map]",
        ),
        (
            "map",
            "hand",
            0.5,
            "extrapolation",
            "0.500000000s into the past.  Requested time 0.500000000 but the earliest",
        ),
        (
            "map",
            "island",
            2,
            "connectivity",
            "Could not find a connection between 'map' and 'island' because they are not part of "
            "the same tree.Tf has two or more unconnected trees.",
        ),
        (
            "sea",
            "island",
            3,
            "extrapolation",
            "extrapolation at time 3.000000000, but only time 2.000000000 is in the buffer",
        ),
    ],
)
def test_what_cannot_be_answered_says_why(tree, target, source, time_s, failure, message):
    tree.place("sea", "island", shifted(), 2 * S, "test", static=False)
    with pytest.raises(FrameError) as raised:
        tree.lookup(target, source, round(time_s * S))
    assert raised.value.failure == failure
    assert message in str(raised.value)
    assert tree.can_transform(target, source, round(time_s * S))[0] is False


@pytest.mark.parametrize(
    ("parent", "child", "pose", "message"),
    [
        ("a", "a", shifted(), "TF_SELF_TRANSFORM"),
        ("a", "", shifted(), "TF_NO_CHILD_FRAME_ID"),
        ("", "a", shifted(), "TF_NO_FRAME_ID"),
        ("a", "b", shifted(math.nan), "TF_NAN_INPUT"),
        ("a", "b", shifted(turn=(0.0, 0.0, 0.0, 0.0)), "TF_DENORMALIZED_QUATERNION"),
    ],
)
def test_a_transform_that_makes_no_sense_is_dropped_and_reported(
    tree, reported, parent, child, pose, message
):
    frames = tree.frames
    assert tree.place(parent, child, pose, S, "somebody", static=False) is False
    assert message in reported[0]
    assert tree.frames == frames


def test_old_and_repeated_poses_are_dropped_and_reported(reported):
    tree = TransformTree(cache_ns=2 * S, warn=reported.append)
    for time_s in (10, 11, 13):
        tree.place("a", "b", shifted(time_s), time_s * S, "test", static=False)
    assert not tree.can_transform("a", "b", 10 * S)[0]
    assert tree.can_transform("a", "b", 11 * S)[0]
    assert not tree.place("a", "b", shifted(), 13 * S, "test", static=False)
    assert not tree.place("a", "b", shifted(), 10 * S, "test", static=False)
    assert "TF_REPEATED_DATA" in reported[0]
    assert "TF_OLD_DATA" in reported[1]


def test_a_loop_is_reported_as_one():
    tree = TransformTree()
    for parent, child in (("a", "b"), ("b", "c"), ("c", "a"), ("x", "y")):
        tree.place(parent, child, shifted(), S, "test", static=False)
    with pytest.raises(FrameError, match="contains a loop"):
        tree.lookup("y", "a", S)


def test_leading_slashes_of_what_is_set_are_dropped():
    tree = TransformTree()
    tree.place("/a", "/b", shifted(1.0), S, "test", static=False)
    assert tree.lookup("a", "b", S)[0].position == (1.0, 0.0, 0.0)


def test_clear_keeps_what_is_static(tree):
    tree.clear()
    assert tree.can_transform("camera", "base", 0)[0]
    assert not tree.can_transform("map", "hand", 0)[0]


def test_the_tree_is_reported_as_text(tree):
    assert "Frame hand exists with parent arm.\n" in tree.as_string()
    assert "hand: \n  parent: 'arm'\n  broadcaster: 'test'\n" in tree.as_yaml()
    assert '"arm" -> "hand"' in tree.as_dot()
    assert tree.chain("camera", 2 * S, "hand", 2 * S, "map") == [
        "hand", "arm", "base", "map", "camera",
    ]  # fmt: skip
