"""The value of what a run brought about: its form in the lock, and how two of them are compared."""

import json
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.outcome.arm import Arm, ArmFrame, tool_pose
from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.kept import MOST_BYTES, kept_outcome, outcome_summary
from tracerisk.common.outcome.outcome import (
    TICK_S,
    CellUse,
    GripperUse,
    ObjectOutcome,
    Outcome,
    Rest,
    moved_line,
    rest_of,
    rounded,
)
from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.outcome.ways import corners, line_distance

Z = (0.0, 0.0, 1.0)
ARM = Arm(
    ("joint1", "joint2", "joint3", "joint4"),
    (
        ArmFrame((0.0, 0.0, 0.3), (0.0, 0.0, 0.0), "joint1", (1.0, 0.0, 0.0), slides=True),
        ArmFrame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "joint2", (0.0, 1.0, 0.0), slides=True),
        ArmFrame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "joint3", (1.0, 0.0, 0.0), slides=True),
        ArmFrame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "joint4", Z),
    ),
)
"""Slides along x, y and x again, and turns the tool about z."""


def thing(name="cup", begin=(0.4, 0.1, 0.05), end=(0.4, -0.2, 0.05), **more) -> ObjectOutcome:
    fields = {"tilt_deg": 0.0, "heading_deg": 0.0, "rests_on": "table", "held_in": ""}
    return ObjectOutcome(name, begin, end, **{**fields, **more})


def outcome(*steps, objects=(), **more) -> Outcome:
    """Return an outcome whose steps come in the order given."""
    placed = [replace(step, order=order) for order, step in enumerate(steps)]
    return Outcome(
        arms=(ARM,),
        objects=tuple(objects),
        rests=tuple(step for step in placed if isinstance(step, Rest)),
        grips=tuple(step for step in placed if isinstance(step, GripperUse)),
        cell=tuple(step for step in placed if isinstance(step, CellUse)),
        **more,
    )


def rest(a: float, b: float = 0.0, c: float = 0.0, d: float = 0.0, **more) -> Rest:
    return rest_of(ARM, (a, b, c, d), **{"took_s": 1.0, **more})


def call(name="/glue/enable", content="data=true", *, succeeded=True) -> CellUse:
    return CellUse(0, "call", name, content, succeeded)


def grip(opened: float, holds="") -> GripperUse:
    return GripperUse(0, "hand", opened, holds)


HOME, ABOVE, DOWN = rest(0.0), rest(0.3), rest(0.3, 0.2)
MISSION = (HOME, ABOVE, DOWN, grip(0.2, "cup"), ABOVE, rest(-0.3), grip(1.0), HOME)
WHOLE = outcome(*MISSION, objects=[thing()])


def test_the_same_outcome_has_no_changes():
    changes = outcome_changes(WHOLE, WHOLE)
    assert not changes
    assert not changes.does_something_else


@pytest.mark.parametrize(
    ("end", "held_in", "expected"),
    [
        ((0.4, 0.1, 0.05), "", "cup is no longer moved"),
        (
            (0.4, -0.225, 0.05),
            "",
            "cup ends 25 mm from where it ended, at (0.400, -0.225, 0.050) m, before: (0.400, -0.200, 0.050) m",
        ),
        ((0.4, -0.2, 0.05), "hand", "cup ends held in hand, before: free"),
    ],
)
def test_where_an_object_ends_is_the_result(end, held_in, expected):
    after = replace(WHOLE, objects=(thing(end=end, held_in=held_in),))
    changes = outcome_changes(WHOLE, after)
    assert changes.result[0] == expected
    assert changes.does_something_else


def test_an_object_within_the_tolerance_is_where_it_was():
    after = replace(WHOLE, objects=(thing(end=(0.402, -0.2, 0.05)),))
    assert not outcome_changes(WHOLE, after)
    assert outcome_changes(WHOLE, after, Tolerances(place_m=0.001))


def test_a_tipped_and_a_turned_object_are_other_results():
    tipped = replace(WHOLE, objects=(thing(tilt_deg=88.0),))
    turned = replace(WHOLE, objects=(thing(heading_deg=90.0),))
    assert outcome_changes(WHOLE, tipped).result == ("cup ends tilted by 88 deg, before: 0 deg",)
    assert outcome_changes(WHOLE, turned).result == ("cup ends turned by 90 deg from how it ended",)


def test_the_heading_of_what_is_round_is_no_result():
    before = replace(WHOLE, objects=(thing(heading_deg=None),))
    assert not outcome_changes(before, replace(WHOLE, objects=(thing(heading_deg=None),)))


def test_a_rest_that_is_lost_is_lost_way():
    after = outcome(*MISSION[:4], *MISSION[5:], objects=[thing()])
    changes = outcome_changes(WHOLE, after)
    assert changes.lost == ("rest 4 of 6 at (0.300, 0.000, 0.300) m is no longer reached",)
    assert not changes.result
    assert changes.does_something_else


def test_a_rest_that_is_added_loses_nothing():
    after = outcome(*MISSION[:5], rest(0.1, 0.1), *MISSION[5:], objects=[thing()])
    changes = outcome_changes(WHOLE, after)
    assert changes.added == ("a rest at (0.100, 0.100, 0.300) m is new",)
    assert not changes.does_something_else


def test_many_rests_in_a_row_that_are_added_are_one_line():
    added = [rest(x, 0.1) for x in (0.1, 0.2, -0.2)]
    after = outcome(*MISSION[:5], *added, *MISSION[5:], objects=[thing()])
    (line,) = outcome_changes(WHOLE, after).added
    assert line == (
        "3 rests in a row are new, from (0.100, 0.100, 0.300) m to (-0.200, 0.100, 0.300) m"
    )


def lifted(a: float, b: float, by_m: float) -> Rest:
    """Return a rest above a place, as an arm that slides along z too would have it."""
    held = rest(a + 0.5, b, -0.5)
    x, y, z = held.tool_m
    return replace(held, tool_m=(x, y, z + by_m))


def test_a_rest_elsewhere_says_how_far_and_where():
    after = outcome(*MISSION[:5], rest(-0.3, 0.024), *MISSION[6:], objects=[thing()])
    (line,) = outcome_changes(WHOLE, after).lost
    where = "rest 5 of 6 at (-0.300, 0.000, 0.300) m is now"
    assert line == f"{where} 24 mm from there, at (-0.300, 0.024, 0.300) m"
    for by_m, word in ((0.05, "higher"), (-0.05, "lower")):
        after = outcome(*MISSION[:5], lifted(-0.3, 0.0, by_m), *MISSION[6:], objects=[thing()])
        assert outcome_changes(WHOLE, after).lost == (f"{where} 50 mm {word}",)


def test_rests_that_one_constant_shifts_are_one_sentence_with_its_direction():
    places = [(0.1, 0.0), (0.2, 0.1), (0.3, 0.2), (0.4, 0.3), (0.5, 0.4)]
    before = outcome(*(rest(x, y) for x, y in places))
    higher = outcome(rest(0.1), *(lifted(x, y, 0.1) for x, y in places[1:]))
    changes = outcome_changes(before, higher)
    assert changes.lost == (
        "4 rests of 5 are now 100 mm higher: 2 to 5, the first at (0.200, 0.100, 0.300) m",
    )
    assert changes.result  # the last rest, which is one of them
    aside = outcome(*(rest(x, y - 0.04 * (y in (0.1, 0.3))) for x, y in places))
    changes = outcome_changes(before, aside)
    assert changes.lost == (
        "2 rests of 5 are now 40 mm away, by (0, -40, 0) mm: 2, 4, the first at (0.200, 0.100, 0.300) m",
    )
    assert changes.is_other_way
    both = outcome(*before.rests[:1], lifted(0.2, 0.1, 0.1), rest(0.3, 0.16), *before.rests[3:])
    assert len(outcome_changes(before, both).lost) == 2


def test_where_the_arm_ends_is_the_result_and_said_once():
    after = outcome(*MISSION[:-1], rest(0.05), objects=[thing()])
    changes = outcome_changes(WHOLE, after)
    assert changes.result == (
        "the arm ends 50 mm from where it ended, at (0.050, 0.000, 0.300) m, before: "
        "(0.000, 0.000, 0.300) m",
    )
    assert not changes.lost


def test_another_posture_at_the_same_place_loses_nothing():
    after = outcome(*MISSION[:2], rest(0.18, 0.2, 0.12), *MISSION[3:], objects=[thing()])
    changes = outcome_changes(WHOLE, after)
    (line,) = changes.added
    assert "is reached in another posture: joint1 is 0.120 m off" in line
    assert not changes.does_something_else


def test_a_tool_turned_otherwise_is_another_rest():
    after = outcome(*MISSION[:2], rest(0.3, 0.2, d=0.5), *MISSION[3:], objects=[thing()])
    (line,) = outcome_changes(WHOLE, after).lost
    assert line.endswith("is now with the tool turned by 29 deg")


def test_an_arm_arrives_a_little_before_its_last_goal():
    near = outcome(*MISSION[:-1], rest(0.008), objects=[thing()])
    assert not outcome_changes(WHOLE, near).result
    assert outcome_changes(WHOLE, near).lost


@pytest.mark.parametrize(
    ("now", "expected"),
    [
        (grip(0.2), "hand goes to 20 % of its opening, before: grips cup"),
        (grip(0.0), "hand closes on nothing, before: grips cup"),
        (grip(0.2, "lid"), "hand grips lid, before: grips cup"),
    ],
)
def test_what_a_gripper_does_is_way(now, expected):
    after = outcome(*MISSION[:3], now, *MISSION[4:], objects=[thing()])
    assert outcome_changes(WHOLE, after).lost == (expected,)


def test_calls_are_counted_by_interface():
    before = outcome(HOME, call(), call(), ABOVE)
    assert outcome_changes(before, outcome(HOME, call(), ABOVE)).result == (
        "/glue/enable is called once, before: twice",
    )
    failing = outcome(HOME, call(), call(succeeded=False), ABOVE)
    assert outcome_changes(before, failing).result == ("/glue/enable succeeds once, before: twice",)


def test_what_a_call_says_is_the_result_figures_within_one_percent():
    before = outcome(HOME, call(content="amount=2.5 unit='ml'"), ABOVE)
    alike = outcome(HOME, call(content="amount=2.51 unit='ml'"), ABOVE)
    other = outcome(HOME, call(content="amount=25 unit='ml'"), ABOVE)
    assert not outcome_changes(before, alike)
    assert outcome_changes(before, other).result == (
        "/glue/enable gets amount=25 unit='ml', before: amount=2.5 unit='ml'",
    )


def test_a_call_at_another_point_of_the_mission_is_lost_way():
    before = outcome(HOME, call(), ABOVE, DOWN)
    after = outcome(HOME, ABOVE, DOWN, call())
    changes = outcome_changes(before, after)
    assert changes.lost == ("/glue/enable is called after rest 3, before: after rest 1",)
    assert not changes.result


def test_another_way_between_the_same_rests_is_named():
    straight = outcome(HOME, rest(0.3))
    around = outcome(HOME, rest(0.3, via_m=((0.15, 0.1, 0.3),)))
    (line,) = outcome_changes(straight, around).lost
    assert line.endswith("is up to 100 mm away from the old one")


def test_another_way_to_the_first_rest_is_named_where_both_beginnings_are_known():
    straight = outcome(rest(0.3, from_m=(0.0, 0.0, 0.3)))
    around = outcome(rest(0.3, from_m=(0.0, 0.0, 0.3), via_m=((0.15, 0.1, 0.3),)))
    changes = outcome_changes(straight, around)
    (line,) = changes.lost
    assert line.startswith("the way to rest 1 of 1")
    assert line.endswith("is up to 100 mm away from the old one")
    assert changes.is_other_way
    assert not outcome_changes(outcome(rest(0.3)), around)


def test_pace_is_named_and_decides_nothing():
    before = outcome(HOME, replace(ABOVE, held_s=3.0, took_s=4.0), DOWN)
    after = outcome(HOME, replace(ABOVE, held_s=0.1, took_s=0.8), DOWN)
    changes = outcome_changes(before, after)
    assert len(changes.pace) == 2
    assert not changes.does_something_else


def test_half_of_the_work_is_another_mission():
    half = outcome(*MISSION[:3], objects=[thing(end=(0.4, 0.1, 0.05))])
    changes = outcome_changes(WHOLE, half)
    assert "cup is no longer moved" in changes.result
    assert any("no longer reached" in line for line in changes.lost)


def test_the_line_of_a_run_says_what_moved():
    assert moved_line(WHOLE) == "1 object moved: cup to (0.400, -0.200, 0.050) m on table"
    still = replace(WHOLE, objects=(thing(end=(0.4, 0.1, 0.05)),))
    assert moved_line(still) == "none of 1 object moved"
    assert moved_line(outcome(HOME)) == ""


def test_half_a_step_is_rounded_up_whatever_the_last_bit():
    assert rounded(0.0005) == rounded(0.0005 - 1e-9) == 0.001
    assert str(rounded(-0.0001)) == "0.0"


millimetres = st.integers(-2000, 2000).map(lambda value: value / 1000.0)
places = st.tuples(millimetres, millimetres, millimetres)
tenths = st.integers(0, 1200).map(lambda value: rounded(value * TICK_S, TICK_S))
names = st.text("abcdefghij_1/", min_size=1, max_size=12).map("x".__add__)
odd_names = st.text("ab%|;@,/ \n\u00e9", min_size=1, max_size=8)
contents = st.text("abc =.'12", max_size=30).map(str.strip)
rests = st.builds(
    rest,
    *(millimetres,) * 4,
    took_s=tenths,
    held_s=tenths,
    via_m=st.lists(places, max_size=3),
    from_m=st.none() | places,
)
uses = st.one_of(
    rests,
    st.builds(
        GripperUse, st.just(0), names, st.integers(0, 100).map(lambda v: v / 100.0), odd_names
    ),
    st.builds(
        CellUse,
        st.just(0),
        st.sampled_from(["call", "message", "goal"]),
        names,
        contents,
        st.booleans(),
    ),
)
degrees = st.integers(0, 180).map(float)
things = st.builds(
    ObjectOutcome, odd_names, places, places, degrees, st.none() | degrees, odd_names, odd_names
)


@given(st.lists(uses, max_size=8), st.lists(things, max_size=3))
def test_the_lock_keeps_an_outcome_whole(steps, objects):
    found = outcome(*steps, objects=objects)
    assert kept_outcome(json.loads(json.dumps(outcome_summary(found)))) == found


@given(st.lists(uses, max_size=8), st.lists(uses, max_size=8))
def test_every_pair_of_outcomes_compares(one, other):
    changes = outcome_changes(outcome(*one), outcome(*other))
    back = outcome_changes(outcome(*other), outcome(*one))
    assert bool(changes) == bool(back)
    assert not outcome_changes(outcome(*one), outcome(*one))


def test_a_long_run_keeps_its_first_steps_in_a_few_kilobytes():
    way = ((0.1, 0.2, 0.3), (0.4, 0.9, 0.3), (0.1, 0.2, 0.9))
    steps = [rest(number / 10.0, via_m=way) for number in range(500)]
    summary = outcome_summary(outcome(*steps))
    assert len(json.dumps(summary, indent=1)) <= MOST_BYTES
    kept = kept_outcome(summary)
    assert kept is not None
    assert kept.left_out == 500 - len(kept.rests)
    assert kept.rests[-1].joints == steps[-1].joints
    assert kept.corner_m == 0.0
    assert kept.rests[:3] == tuple(
        replace(step, order=order, via_m=()) for order, step in enumerate(steps[:3])
    )


@pytest.mark.parametrize("data", [None, [], "x", {"way": ["r"]}, {"objects": ["a|b"]}])
def test_a_lock_edited_by_hand_has_no_outcome(data):
    assert kept_outcome({"outcome": data}) is None


def long_run(number=500, *, pause_s=0.0, last=None) -> Outcome:
    """Return what the lock keeps of a run with too many steps."""
    steps = [rest(place / 10.0, held_s=pause_s) for place in range(number)]
    steps[10:10] = [call() for _ in range(3)]
    kept = kept_outcome(outcome_summary(outcome(*steps, *([last] if last else []))))
    assert kept is not None
    assert kept.left_out
    return kept


def test_of_a_long_run_steps_ends_and_counts_are_compared():
    assert not outcome_changes(long_run(), long_run(pause_s=0.3))
    assert outcome_changes(long_run(), long_run(499)).lost == (
        "the mission has 502 steps in all, before: 503",
    )
    ends = outcome_changes(long_run(last=rest(0.1)), long_run(last=rest(0.2)))
    assert ends.result == (
        "the arm ends 100 mm from where it ended, at (0.200, 0.000, 0.300) m, before: "
        "(0.100, 0.000, 0.300) m",
    )
    assert long_run().cell_counts[0].uses == 3


def test_fewer_corners_are_kept_where_there_is_no_room_for_all():
    wave = tuple((number / 100.0, 0.02 * (number % 2), 0.3) for number in range(40))
    steps = [rest(number / 10.0, via_m=wave) for number in range(20)]
    kept = kept_outcome(outcome_summary(outcome(*steps)))
    assert kept is not None
    assert len(kept.rests) == 20
    assert kept.corner_m == 0.025
    assert not outcome_changes(outcome(*steps), kept)


@given(st.lists(places, min_size=2, max_size=20), st.sampled_from([0.003, 0.05, 0.3]))
def test_a_way_lies_within_reach_of_the_lines_between_its_corners(points, within_m):
    way = [points[0], *corners(points, within_m), points[-1]]
    assert all(min(line_distance(p, a, b) for a, b in pairwise(way)) <= within_m for p in points)


@given(st.tuples(*(millimetres,) * 4))
def test_the_kept_arm_has_its_tool_where_the_twin_has_it(joints):
    (x, y, z), _ = tool_pose(ARM, joints)
    assert (x, y, z) == pytest.approx((joints[0] + joints[2], joints[1], 0.3))


def test_whole_numbers_are_compared_exactly():
    before = outcome(HOME, call(content="program=1001 speed=2.5"), ABOVE)
    assert outcome_changes(before, outcome(HOME, call(content="program=1002 speed=2.5"), ABOVE))
    assert not outcome_changes(
        before, outcome(HOME, call(content="program=1001 speed=2.51"), ABOVE)
    )


def test_a_call_that_moves_is_named_and_not_the_rest_that_stays():
    later = outcome(HOME, ABOVE, DOWN, call(), rest(0.1))
    earlier = outcome(HOME, ABOVE, call(), DOWN, rest(0.1))
    for one, other, words in (
        (later, earlier, "/glue/enable is called after rest 2, before: after rest 3"),
        (earlier, later, "/glue/enable is called after rest 3, before: after rest 2"),
    ):
        changes = outcome_changes(one, other)
        assert (changes.lost, changes.added) == ((words,), ())


def test_a_stream_that_becomes_single_messages_is_another_result():
    stream = outcome(HOME, ABOVE, streams=("/alive",))
    twice = outcome(HOME, *(CellUse(0, "message", "/alive", ""),) * 2, ABOVE)
    assert outcome_changes(stream, twice).result == (
        "messages are sent on /alive twice, before: at a steady rate",
    )
    assert outcome_changes(twice, stream).result


def test_in_a_long_run_a_step_more_loses_none_at_its_end():
    shorter, longer = (
        kept_outcome(outcome_summary(outcome(*first, *(rest(i / 10.0) for i in range(400)))))
        for first in ((), (rest(-0.5),))
    )
    changes = outcome_changes(shorter, longer)
    assert changes.lost == ()
    assert any(line.startswith("a rest at (-0.500") for line in changes.added)


def test_grippers_are_compared_each_with_itself():
    before = outcome(HOME, GripperUse(0, "right_hand", 1.0, ""), ABOVE)
    after = outcome(HOME, GripperUse(0, "left_hand", 0.0, ""), ABOVE)
    changes = outcome_changes(before, after)
    assert changes.lost == ("right_hand no longer opens",)
    assert changes.added == ("left_hand newly closes on nothing",)


MOVED = "cup_2 is new in the scene and is moved by 300 mm to (0.400, -0.200, 0.050) m"


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({}, f"{MOVED}, ends on table"),
        ({"rests_on": ""}, f"{MOVED}, ends on nothing"),
        ({"held_in": "hand"}, "cup_2 is new in the scene and ends held in hand"),
        ({"end": (0.4, 0.1, 0.05)}, "cup_2 is new in the scene and is not moved"),
    ],
)
def test_of_a_new_object_it_is_said_what_the_mission_does_with_it(more, words):
    after = replace(WHOLE, objects=(thing(), thing("cup_2", **more)))
    assert outcome_changes(WHOLE, after).result == (words,)


def test_of_an_object_that_is_gone_it_is_said_what_the_mission_did_with_it():
    changes = outcome_changes(replace(WHOLE, objects=(thing(), thing("cup_2"))), WHOLE)
    assert changes.result == ("cup_2 is no longer in the scene, before: it was moved by 300 mm",)


def test_a_use_of_a_gripper_that_both_runs_have_comes_more_or_less_often():
    again = (rest(0.5), grip(0.2, "cup_2"), rest(-0.5), grip(1.0))
    after = outcome(*MISSION, *again, HOME, objects=[thing()])
    place = "at (-0.500, 0.000, 0.300) m"
    more = outcome_changes(WHOLE, after).added
    assert f"hand opens one time more, {place}" in more
    assert "hand newly grips cup_2" in more
    less = outcome_changes(after, WHOLE).lost
    assert f"hand opens one time less, {place}" in less
    assert "hand no longer grips cup_2" in less


def test_where_an_object_is_no_longer_set_down_on_its_way_comes_first():
    take, put = (rest(0.5), grip(0.2, "cup")), (rest(-0.5, 0.3), grip(1.0))
    scale = (rest(0.1, 0.2), grip(1.0), rest(0.1, 0.2), grip(0.2, "cup"))
    weighed = outcome(HOME, *take, *scale, *put, HOME, objects=[thing()])
    straight = outcome(HOME, *take, *put, HOME, objects=[thing()])
    changes = outcome_changes(weighed, straight)
    assert changes.lost[0] == "cup is no longer set down at (0.100, 0.200, 0.300) m"
    assert not any("set down" in line for line in outcome_changes(straight, weighed).of_mission)
    # Elsewhere is another rest, and no set-down less.
    aside = (rest(0.2, 0.2), grip(1.0), rest(0.2, 0.2), grip(0.2, "cup"))
    other = outcome(HOME, *take, *aside, *put, HOME, objects=[thing()])
    assert not any("set down" in line for line in outcome_changes(weighed, other).of_mission)


def test_of_an_object_that_was_not_moved_before_it_is_said_where_it_ends():
    still = replace(WHOLE, objects=(thing(), thing("cup_2", end=(0.4, 0.1, 0.05))))
    moved = replace(WHOLE, objects=(thing(), thing("cup_2")))
    changes = outcome_changes(still, moved)
    assert changes.result[0] == (
        "cup_2 is moved by 300 mm to (0.400, -0.200, 0.050) m, before: not moved"
    )
    assert changes.newly_moved == ("cup_2",)
    assert outcome_changes(moved, still).newly_moved == ()
