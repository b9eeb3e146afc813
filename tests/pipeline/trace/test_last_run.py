"""What the lock keeps of a run for a reviewer: motions that never ran, and contacts."""

import json
import random

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.verdict import Uncovered
from tracerisk.pipeline.trace.last_run import (
    UnexpectedContact,
    kept_contacts,
    kept_uncovered,
    last_run_summary,
)
from tracerisk.trace import Contact, RunEnd, Trace, Visit


def ref(name, file="arm.py"):
    return FunctionRef(file, QualifiedName(name))


def touch(link, other, *, expected=False, force=3.0):
    return Contact(link, other, 1.0, 0.5, force, expected)


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


def test_names_and_bodies_are_kept_sorted_without_times_and_forces():
    assert last_run_summary(trace(VISITS, NEVER)) == {
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
    summary = {"uncovered": value, "unexpected_contacts": value}
    assert kept_uncovered(summary) == ()
    assert kept_contacts(summary) == ()


def test_a_pair_of_more_or_fewer_bodies_is_left_out():
    pairs = [["hand"], ["hand", "table", "rack"], ["hand", 3], "ab", ["hand", "table"]]
    found = kept_contacts({"unexpected_contacts": {"arm.py": {"place": pairs}}})
    assert found == (UnexpectedContact(ref("place"), "hand", "table"),)
