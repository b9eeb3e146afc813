"""What the lock keeps of a run for a reviewer: motions that never ran, and contacts."""

import json
import random
from dataclasses import replace

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.elements import Contact
from tracerisk.common.verdict import Uncovered
from tracerisk.pipeline.trace.last_run import (
    Touches,
    UnexpectedContact,
    contact_text,
    kept_contacts,
    kept_repeats,
    kept_touches,
    kept_uncovered,
    last_run_summary,
    repeats_summary,
)
from tracerisk.trace import RunEnd, Trace, Visit


def ref(name, file="arm.py"):
    return FunctionRef(file, QualifiedName(name))


def touch(link, other, *, expected=False, force=3.0, from_grasp_s=None):
    return Contact(link, other, 1.0, 0.5, force, expected, from_grasp_s)


def visit(name, *contacts, file="arm.py"):
    return Visit(ref(name, file), 0.0, 1.0, "succeeded", {}, contacts=contacts)


def trace(visits, uncovered=()):
    return Trace(
        "arm.py",
        "panda",
        "empty",
        RunEnd("ended", "it returned", 1.0),
        (),
        (),
        tuple(visits),
        uncovered=tuple(uncovered),
    )


def test_a_live_run_repeats_the_less_the_shorter_its_first_and_last_functions_are():
    visits = [visit("find"), visit("pick"), visit("pick"), visit("leave"), visit("leave")]
    run = trace(visits)
    live = replace(run, assumptions=("measured: live, on real ROS 1",))
    repeats = [
        repeats_summary(live, [each for each in visits if each.function.name == name])
        for name in ("find", "pick", "leave", "none")
    ]
    assert repeats == [{"repeats": 0.25}, {"repeats": 0.03}, {"repeats": 0.18}, {}]
    assert repeats_summary(run, visits) == {}
    summary = {"functions": {"find": repeats[0], "pick": {"repeats": "much"}}}
    assert [kept_repeats(summary, name) for name in ("find", "pick", "none")] == [0.25, 0.0, 0.0]


VISITS = (
    visit("place", touch("hand", "table"), touch("finger", "tube", expected=True)),
    visit("pick", touch("link5", "link7"), touch("hand", "table", force=20.0)),
    visit("place", touch("hand", "table"), touch("hand", "rack")),
    visit("pick", touch("tube", "rack"), file="other.py"),
)
NEVER = (
    Uncovered(ref("recover"), 40),
    Uncovered(ref("Node.back"), 12),
    Uncovered(ref("recover", "b.py"), 3),
)


def test_names_and_bodies_are_kept_sorted_and_how_they_touched_beside_them():
    summary = last_run_summary(trace(VISITS, NEVER))
    touches = summary.pop("touches")
    assert list(touches) == ["arm.py", "other.py"]
    assert touches["arm.py"]["place"]["hand"]["table"] == {
        "unexpected": {"number": 2, "force_n": 3.0, "touching_s": 1.0, "start_s": 1.0}
    }
    assert summary == {
        "uncovered": {"arm.py": ["Node.back", "recover"], "b.py": ["recover"]},
        "unexpected_contacts": {
            "arm.py": {
                "pick": [["hand", "table"], ["link5", "link7"]],
                "place": [["hand", "rack"], ["hand", "table"]],
            },
            "other.py": {"pick": [["tube", "rack"]]},
        },
    }


def test_the_order_of_the_run_and_its_forces_change_no_byte():
    kept = json.dumps(last_run_summary(trace(VISITS, NEVER)))
    shuffle = random.Random(3)
    visits, never = list(VISITS), list(NEVER)
    for _ in range(5):
        shuffle.shuffle(visits)
        shuffle.shuffle(never)
        assert json.dumps(last_run_summary(trace(visits, never))) == kept


def test_nothing_to_see_adds_no_key():
    fine = visit("place", touch("finger", "tube", expected=True))
    assert last_run_summary(trace([fine])) == {}


def test_what_is_kept_is_read_back():
    summary = json.loads(json.dumps(last_run_summary(trace(VISITS, NEVER))))
    assert set(kept_uncovered(summary)) == {each.ref for each in NEVER}
    assert set(kept_contacts(summary)) == {
        UnexpectedContact(ref("place"), "hand", "table"),
        UnexpectedContact(ref("place"), "hand", "rack"),
        UnexpectedContact(ref("pick"), "hand", "table"),
        UnexpectedContact(ref("pick"), "link5", "link7"),
        UnexpectedContact(ref("pick", "other.py"), "tube", "rack"),
    }


@pytest.mark.parametrize("value", [None, 3, "x", [], ["x"], {"a": 1}, {"a": [3]}, {"a": {"f": 2}}])
def test_what_a_person_made_of_the_lock_is_left_out(value):
    summary = {"uncovered": value, "unexpected_contacts": value, "touches": value}
    assert kept_uncovered(summary) == ()
    assert kept_contacts(summary) == ()
    pair = UnexpectedContact(ref("f", "a"), "hand", "table")
    assert kept_touches(summary, pair) == (None, None)


def test_a_pair_of_more_or_fewer_bodies_is_left_out():
    pairs = [["hand"], ["hand", "table", "rack"], ["hand", 3], "ab", ["hand", "table"]]
    found = kept_contacts({"unexpected_contacts": {"arm.py": {"place": pairs}}})
    assert found == (UnexpectedContact(ref("place"), "hand", "table"),)


def test_a_touch_of_what_is_grasped_is_kept_though_it_was_expected():
    grasp = touch("palm", "tube", expected=True, force=30.1, from_grasp_s=-0.7)
    summary = last_run_summary(trace([visit("pick", grasp)]))
    assert list(summary) == ["touches"]
    kept = kept_touches(summary, UnexpectedContact(ref("pick"), "palm", "tube"))
    assert kept == (Touches(1, 30.1, 0.5, 1.0, -0.7), None)
    other = UnexpectedContact(ref("place"), "palm", "tube")
    assert kept_touches(summary, other) == (None, None)


def test_a_contact_is_named_with_force_time_and_its_distance_from_the_grasp():
    bump = touch("palm", "tube", force=30.1, from_grasp_s=-1.5)
    grasp = touch("palm", "tube", force=70.0, expected=True, from_grasp_s=0.0)
    (kept,) = kept_contacts(last_run_summary(trace([visit("pick", bump, grasp)])))
    assert str(kept) == (
        "palm and tube touched in pick, which was not to be expected: up to 30 N, 0.50 s, at "
        "1.0 s, 1.5 s before it is held"
    )
    text = contact_text(kept, [bump], {"palm"})
    assert text == "palm touches tube in pick: up to 30 N, 0.50 s, 1.5 s before it is held"


def test_a_held_thing_that_is_pressed_on_is_named_with_what_would_be_expected():
    pressed, gentle = (touch("tube", "floor", force=force) for force in (26.0, 3.0))
    pair = UnexpectedContact(ref("pick"), "tube", "floor")
    text = "tube, which is held, touches floor in pick: up to 26 N, 0.50 s"
    borne = "what a thing is lifted from or put on may bear 20 N and twice its weight"
    assert contact_text(pair, [pressed], {"palm"}) == f"{text}; {borne}"
    assert "bear" not in contact_text(pair, [gentle], {"palm"})


@pytest.mark.parametrize(
    ("now", "is_same"),
    [
        (Touches(1, 30.0, 0.04, 9.0, -1.5), True),
        (Touches(1, 30.0, 0.04, 9.0), False),  # it is grasped no more
        (Touches(2, 30.0, 0.04, 9.0, -1.5), False),  # it is bumped into, then grasped
        (Touches(1, 60.0, 0.04, 9.0, -1.5), False),
        (Touches(1, 30.0, 2.0, 9.0, -1.5), False),
    ],
)
def test_touches_are_the_same_by_number_force_and_duration_whatever_their_class(now, is_same):
    assert now.are_of_grasp_as(Touches(1, 30.1, 0.036, 6.0, -0.7)) == is_same
