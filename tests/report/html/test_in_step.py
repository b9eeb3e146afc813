"""Two runs on one axis: where both are at the same step, and what only one of them does."""

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.outcome.arm import Arm, ArmFrame
from tracerisk.common.outcome.outcome import GripperUse, Outcome, rest_of
from tracerisk.report.html.run.in_step import in_step
from tracerisk.trace import RunEnd, Trace, TracedCommand, Visit

ARM = Arm(("slide",), (ArmFrame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "slide", slides=True),))
END_S = 1.0
"""How long every run goes on behind its last step [s]."""


def moved(to, took_s=1.0, stays_s=0.5, function="go"):
    """A motion of the arm to a place, or a command to the gripper named `to`."""
    return to, took_s, stays_s, FunctionRef("arm.py", QualifiedName(function))


def run(*motions, outcome=True):
    """The trace of a run that does these things, one after the other."""
    now, commands, steps, visits = 0.0, [], [], []
    for order, (to, took_s, stays_s, function) in enumerate(motions):
        element = to if isinstance(to, str) else "slide"
        end_s = now + took_s
        commands.append(
            TracedCommand(function, 10 + order, "move_group", (element,), now, end_s, "arrived")
        )
        visits.append(Visit(function, now, took_s, "success", {}))
        if isinstance(to, str):
            steps.append(GripperUse(order, to, 0.0, "tube"))
        else:
            steps.append(rest_of(ARM, (to,), order=order, took_s=took_s, held_s=stays_s))
        now = end_s + stays_s
    rests = tuple(step for step in steps if not isinstance(step, GripperUse))
    grips = tuple(step for step in steps if isinstance(step, GripperUse))
    return Trace(
        controller="arm.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "the controller ended", simulated_s=now + END_S),
        elements=(),
        functions=(),
        visits=tuple(visits),
        commands=tuple(commands),
        outcome=Outcome((ARM,), rests=rests, grips=grips) if outcome else None,
    )


def kinds(aligned):
    """What the stretches are, those in a row that are alike once."""
    names = [stretch.kind for stretch in aligned.stretches]
    return [name for name, before in zip(names, [None, *names], strict=False) if name != before]


def spans(aligned, kind, side):
    return [getattr(each, side) for each in aligned.stretches if each.kind == kind]


def test_of_the_same_run_both_are_always_at_the_same_time():
    way = [moved(0.2), moved("hand", 0.4), moved(0.6), moved(0.1)]
    aligned = in_step(run(*way), run(*way))
    assert kinds(aligned) == ["same"]
    assert not aligned.differences
    assert aligned.length_s == pytest.approx(6.4)
    for place in (0.0, 1.0, 2.3, 6.4):
        assert aligned.times_at(place) == pytest.approx((place, place))


def test_of_a_slower_run_the_corresponding_rests_are_at_one_place():
    quick = run(moved(0.2), moved("hand", 0.4), moved(0.6))
    slow = run(moved(0.2, 3.0), moved("hand", 0.8), moved(0.6, 2.0, 1.5))
    aligned = in_step(quick, slow)
    assert kinds(aligned) == ["same"]
    # Arrived, gripped, arrived: whenever one is there, so is the other.
    for pair in ((1.0, 3.0), (1.9, 4.3), (3.4, 6.8)):
        place = next(
            start
            for start in _places(aligned)
            if aligned.times_at(start)[0] == pytest.approx(pair[0])
        )
        assert aligned.times_at(place) == pytest.approx(pair)
    assert aligned.times_at(aligned.length_s) == pytest.approx((4.9, 9.3))


def _places(aligned):
    """Where stretches of the axis end."""
    total = 0.0
    for stretch in aligned.stretches:
        total += stretch.length_s
        yield total


def test_a_rest_that_only_one_run_has_is_waited_for_by_the_other():
    short = run(moved(0.2), moved(0.6), moved(0.1))
    long = run(moved(0.2), moved(0.4, 2.0), moved(0.6), moved(0.1))
    more = in_step(short, long)
    assert kinds(more) == ["same", "now", "same"]
    # The earlier run stands where it was until the later one is there and goes on.
    ((begin_s, end_s),) = spans(more, "now", "before")
    assert begin_s == end_s == pytest.approx(1.5)
    assert spans(more, "now", "now") == [pytest.approx((1.5, 4.0))]
    (difference,) = more.differences
    assert difference.words == ("a rest at (0.000, 0.000, 0.400) m is new",)
    assert (difference.before, difference.now.line) == (None, 11)
    less = in_step(long, short)
    assert kinds(less) == ["same", "before", "same"]
    assert spans(less, "before", "before") == [pytest.approx((1.5, 4.0))]
    assert (
        "rest 2 of 4 at (0.000, 0.000, 0.400) m is no longer reached" in less.differences[0].words
    )


def test_a_rest_that_is_elsewhere_is_reached_by_both_at_one_place():
    aligned = in_step(
        run(moved(0.2), moved(0.4, 2.0), moved(0.6)), run(moved(0.2), moved(0.5, 1.0), moved(0.6))
    )
    assert kinds(aligned) == ["same", "other", "same"]
    (difference,) = aligned.differences
    assert difference.words == ("rest 2 of 3 at (0.000, 0.000, 0.400) m is now 100 mm higher",)
    assert (difference.before_s, difference.now_s) == pytest.approx((3.5, 2.5))
    there = next(pair for pair in map(aligned.times_at, _places(aligned)) if pair[0] > 3.4)
    assert there == pytest.approx((3.5, 2.5))


@pytest.mark.parametrize("outcome", [True, False])
def test_time_never_goes_back_and_both_runs_are_shown_whole(outcome):
    one = run(moved(0.2), moved("hand"), moved(0.3), moved(0.4), moved(0.9), outcome=outcome)
    other = run(moved(0.3), moved(0.2), moved(0.7), moved("hand"), moved(0.9), moved(0.2))
    aligned = in_step(one, other)
    ends = [(0.0, 0.0)]
    for stretch in aligned.stretches:
        assert (stretch.before[0], stretch.now[0]) == ends[-1]
        assert stretch.length_s > 0.0
        ends.append((stretch.before[1], stretch.now[1]))
    assert ends == sorted(ends)
    assert ends[-1] == (one.end.simulated_s, other.end.simulated_s)


def test_without_outcomes_the_visits_that_both_begin_with_are_aligned():
    one = run(moved(0.2, 1.0, 0.0, "init"), moved(0.3, 1.0, 0.0, "pick"), outcome=False)
    other = run(moved(0.2, 3.0, 0.0, "start"), moved(0.3, 1.0, 0.0, "pick"), outcome=False)
    aligned = in_step(one, other, renamed={"init": "start"})
    assert aligned.stretches[0].before == (0.0, 1.0)
    assert aligned.stretches[0].now == (0.0, 3.0)
