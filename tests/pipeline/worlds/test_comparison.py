"""What of two runs counts as a dependence on a world, and what a world changes by itself."""

from dataclasses import replace

import pytest

from tracerisk.common.outcome.arm import Arm, ArmFrame
from tracerisk.common.outcome.outcome import CellUse, GripperUse, Outcome, rest_of
from tracerisk.common.outcome.tolerances import TOLERANCES
from tracerisk.common.verdict import Reason, Verdict
from tracerisk.common.worlds.world import world_named
from tracerisk.errors import Location
from tracerisk.pipeline.worlds.comparison import compared
from tracerisk.trace import RunEnd, Trace

ARM = Arm(
    ("pan", "lift"),
    (
        ArmFrame((0.0, 0.0, 0.3), (0.0, 0.0, 0.0), "pan"),
        ArmFrame((0.4, 0.0, 0.0), (0.0, 0.0, 0.0), "lift", (0.0, 1.0, 0.0)),
        ArmFrame((0.3, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ),
)
LATENCY, GRIPPER = world_named("latency"), world_named("gripper-open")


def run(*postures, verdict="complete", reasons=(), grips=(), cell=(), vias=()):
    """A trace that rests in postures, with the corners of the ways there."""
    rests = tuple(
        rest_of(ARM, posture, order=10 * number, via_m=vias[number] if vias else ())
        for number, posture in enumerate(postures)
    )
    outcome = Outcome((ARM,), rests=rests, grips=grips, cell=cell)
    end = RunEnd("ended", "the controller ended", 3.0)
    judged = Verdict(verdict, tuple(reasons))
    return Trace("pick.py", "arm", "empty", end, (), (), (), verdict=judged, outcome=outcome)


def depends(old, new, world=LATENCY, lost=()):
    return compared(world, old, new, TOLERANCES, lost)


NOMINAL = run((0.0, 0.0), (0.5, 0.2), (0.0, 0.5))


def test_the_same_depends_on_nothing():
    assert not depends(NOMINAL, NOMINAL).depends


def test_a_rest_that_is_no_longer_reached_depends():
    found = depends(NOMINAL, run((0.0, 0.0), (0.0, 0.5)))
    assert found.depends
    assert "is no longer reached" in found.words


def test_a_rest_that_the_arm_passes_does_not():
    middle = NOMINAL.outcome.rests[1].tool_m
    passes = run((0.0, 0.0), (0.0, 0.5), vias=((), (middle,)))
    assert not depends(NOMINAL, passes).depends


def test_what_is_done_in_addition_does_not():
    more = run((0.0, 0.0), (0.5, 0.2), (-0.5, 0.2), (0.0, 0.5))
    assert not depends(NOMINAL, more).depends


def test_a_few_millimetres_do_not_and_more_do():
    assert not depends(NOMINAL, run((0.0, 0.0), (0.51, 0.2), (0.0, 0.5))).depends
    assert depends(NOMINAL, run((0.0, 0.0), (0.55, 0.2), (0.0, 0.5))).depends


@pytest.mark.parametrize(
    ("code", "kind", "counts"),
    [
        ("command-aborted", "faulted", True),
        ("unmet-need", "partial", True),
        ("input-assumed", "partial", False),
        ("never-ran", "partial", False),
    ],
)
def test_a_new_reason_counts_unless_it_says_what_was_assumed_or_left_out(code, kind, counts):
    reason = Reason(code, kind, "it happened", location=Location("pick.py", 7))
    verdict = kind if counts else "complete"
    new = run((0.0, 0.0), (0.5, 0.2), (0.0, 0.5), verdict=verdict, reasons=(reason,))
    found = depends(NOMINAL, new)
    assert found.depends == counts
    if counts:
        assert (found.reason, found.location) == ("it happened", Location("pick.py", 7))


def test_a_reason_that_the_run_itself_has_does_not_count():
    reason = Reason("command-aborted", "faulted", "it stopped 0.2 rad short", "go")
    old = run((0.0, 0.0), verdict="faulted", reasons=(reason,))
    new = run(
        (0.0, 0.0), verdict="faulted", reasons=(replace(reason, words="it stopped 0.3 rad short"),)
    )
    assert not depends(old, new).depends


def test_the_line_is_that_of_what_was_lost():
    shorter = run((0.0, 0.0), (0.0, 0.5))
    found = depends(NOMINAL, shorter, lost=(("a message on /t is lost", "pick.py", 18),))
    assert (found.cause, found.location) == ("a message on /t is lost", Location("pick.py", 18))


def test_what_was_lost_without_a_difference_is_nothing():
    found = depends(NOMINAL, NOMINAL, lost=(("a message on /t is lost", "pick.py", 18),))
    assert not found.depends
    assert found.cause == ""


def use(order, name, content=""):
    return CellUse(order, "message", name, content)


def test_how_often_a_message_goes_out_counts_where_there_are_few():
    few = [run((0.0, 0.0), cell=tuple(use(n, "/glue") for n in range(count))) for count in (2, 1)]
    many = [run((0.0, 0.0), cell=tuple(use(n, "/pose") for n in range(count))) for count in (9, 7)]
    assert depends(*few).depends
    assert not depends(*many).depends


def test_what_the_cell_is_asked_for_in_addition_does_not_count():
    assert not depends(run((0.0, 0.0)), run((0.0, 0.0), cell=(use(1, "/more"),))).depends


def test_the_first_use_of_a_gripper_is_the_doing_of_a_world_that_moves_it():
    opens, grips = GripperUse(1, "hand", 1.0, ""), GripperUse(2, "hand", 0.3, "part")
    old = run((0.0, 0.0), grips=(opens, grips))
    new = run((0.0, 0.0), grips=(grips,))
    assert not depends(old, new, GRIPPER).depends
    assert depends(old, run((0.0, 0.0), grips=(opens,)), GRIPPER).depends
