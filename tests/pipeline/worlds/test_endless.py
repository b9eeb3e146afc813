"""A loop without an end is compared by what each cycle does, not by where it is cut."""

from dataclasses import replace

from tests.pipeline.worlds.test_comparison import depends, run
from tracerisk.common.verdict import Reason, Verdict

CYCLE = ((0.0, 0.0), (0.5, 0.2))


def endless(*postures, cause="cycles"):
    trace = run(*postures)
    return replace(trace, end=replace(trace.end, cause=cause))


def test_where_it_is_cut_says_nothing():
    nominal = endless(*CYCLE, *CYCLE, *CYCLE, *CYCLE)
    assert not depends(nominal, endless(*CYCLE, *CYCLE, *CYCLE, CYCLE[0], cause="duration")).depends
    assert not depends(nominal, endless(*CYCLE, *CYCLE, *CYCLE, *CYCLE, *CYCLE)).depends


def test_a_place_that_no_cycle_comes_to_depends():
    nominal = endless(*CYCLE, *CYCLE, *CYCLE, *CYCLE)
    other = ((0.0, 0.0), (1.0, 0.2))
    assert depends(nominal, endless(*other, *other, *other, *other)).depends


def test_what_the_gripper_holds_when_it_is_cut_says_nothing():
    reason = Reason("never-released", "partial", "the hand is closed at the end")
    cut = replace(endless(*CYCLE, *CYCLE, *CYCLE, *CYCLE), verdict=Verdict("partial", (reason,)))
    assert not depends(endless(*CYCLE, *CYCLE, *CYCLE, *CYCLE), cut).depends
    assert depends(run(*CYCLE), replace(run(*CYCLE), verdict=cut.verdict)).depends
