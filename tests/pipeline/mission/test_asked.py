"""What a later `success` asks less than an earlier one, condition by condition."""

import pytest

from tracerisk.pipeline.mission.asked import asked_change

# Each second condition asks more than the first, or the same in other words.
STRICTER = (
    ("{object: cup, at: tray, within: 0.05}", "{object: cup, at: tray}"),
    ("{object: cup, at: tray}", "{object: cup, at: tray, tilt: 0.1}"),
    ("{object: cup, tilt: 0.2}", "{object: cup, tilt: 0.1}"),
    ("{object: cup, moved: true}", "{object: cup, moved: true, within: 0.2}"),
    ("{object: cup, moved: false, within: 0.2}", "{object: cup, moved: false}"),
    ("{object: cup, at: tray}", "{object: cup, at: tray, rests_on: tray}"),
    ("{object: cup}", "{object: cup, within: 0.001}"),
    ("{joints: {a: 1.0}}", "{joints: {a: 1.0, b: 2.0}}"),
    ("{reached: {a: 1.0}, within: 0.1}", "{reached: {a: 1.0}}"),
    ("{link: tool, at: [1, 2, 3], within: 0.1}", "{link: tool, at: [1, 2, 3]}"),
    ("{called: weld}", "{called: weld, times: 2}"),
    ("{called: weld}", "{called: weld, exactly: 1}"),
    ("{called: weld}", "{called: weld, with: {seam: 3}}"),
    ("{within_s: 30}", "{within_s: 20}"),
    (
        "{steps: [{called: weld}, {object: cup, at: tray}]}",
        "{steps: [{called: weld, times: 2}, {object: cup, at: tray}]}",
    ),
)
# Neither of the two asks all that the other asks.
OTHER = (
    ("{object: cup, at: tray}", "{object: cup, at: shelf}"),
    ("{object: cup, at: tray}", "{object: can, at: tray}"),
    ("{object: cup, moved: true}", "{object: cup, moved: false}"),
    ("{object: cup, held_by: hand}", "{object: cup, held_by: claw}"),
    ("{joints: {a: 1.0}}", "{joints: {a: 2.0}}"),
    ("{joints: {a: 1.0}}", "{reached: {a: 1.0}}"),
)


@pytest.mark.parametrize(("loose", "strict"), STRICTER)
def test_what_asks_more_asks_nothing_less(read, loose, strict):
    old, new = read(loose), read(strict)
    assert asked_change(old, new).less == ()
    assert asked_change(old, new).newly == (new[0].words,)
    (less,) = asked_change(new, old).less
    was, _, now = less.partition("; now: ")
    assert was == new[0].words
    assert now
    assert now in old[0].words
    assert asked_change(new, old).newly == ()


@pytest.mark.parametrize(("one", "other"), OTHER)
def test_what_asks_something_else_asks_less(read, one, other):
    for old, new in ((read(one), read(other)), (read(other), read(one))):
        (less,) = asked_change(old, new).less
        assert less.startswith(old[0].words)


def test_a_call_more_exactly_is_asked_otherwise_and_one_fewer_is_less(read):
    one, two = read("{called: weld, exactly: 1}"), read("{called: weld, exactly: 2}")
    assert (asked_change(one, two).less, asked_change(one, two).newly) == ((), ())
    assert asked_change(one, two).otherwise == (f"{two[0].words}; before: exactly 1 time",)
    assert asked_change(two, one).otherwise == ()
    assert asked_change(two, one).less == (f"{two[0].words}; now: exactly 1 time",)


def test_a_line_that_is_gone_is_not_paired_with_one_that_stays(read):
    at = "{object: jar, at: tray, within: %s}"
    rest = "{object: jar, rests_on: tray, tilt: 0.1}"
    old = read(at % 0.01, rest)
    assert asked_change(old, read(at % 0.05, rest)).less == (
        "jar at tray within 0.01 m; now: within 0.05 m",
    )
    assert asked_change(old, read(at % 0.01)).less == ("jar tilted by at most 0.1 rad, on tray",)


def test_lines_that_are_gone_come_before_those_that_are_looser(read):
    at, weighed = "{object: jar, at: tray, within: %s}", "{called: weigh, exactly: 2}"
    assert asked_change(read(at % 0.01, weighed), read(at % 0.05)).less == (
        "called /weigh exactly 2 times",
        "jar at tray within 0.01 m; now: within 0.05 m",
    )


def test_a_line_that_nobody_confirms_any_more_asks_less(read):
    line = "{object: cup, at: tray}"
    confirmed, assumed = read(line), read(f"{line} # assumed")
    assert assumed[0].is_assumed
    (less,) = asked_change(confirmed, assumed).less
    assert "assumed: nobody has confirmed it" in less
    assert asked_change(assumed, confirmed).less == ()


def test_the_order_of_lines_is_no_change(read):
    lines = ("{object: cup, at: tray}", "{called: weld}")
    old, new = read(*lines), read(*reversed(lines))
    assert asked_change(old, new).less == asked_change(old, new).newly == ()
