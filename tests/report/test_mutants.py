"""The table of a controller's changes: first what nobody notices."""

import itertools
from dataclasses import replace

import pytest

from tracerisk.common.text.paper import Paper
from tracerisk.report.mutants import MutantRun, MutantRuns, ordered, render_mutants, summary_line

ENDS = "cup ends 30 mm from where it ended"


def run(line, *, differs=(ENDS,), success=False, verdict=False, is_whole=True, reason=""):
    return MutantRun(
        "pick.py",
        line,
        "place",
        "sign",
        f"{line} becomes -{line}",
        verdict="complete" if is_whole else "stuck",
        reason=reason,
        differs=differs,
        is_whole=is_whole,
        success_notices=success,
        verdict_notices=verdict,
    )


RUNS = (
    run(1, success=True),
    run(2, success=True, verdict=True, reason="the gripper closed on nothing"),
    run(3, verdict=True, reason="a motion ended before its goal"),
    run(4),
    run(5, differs=()),
    run(6, differs=(), is_whole=False, reason="nothing moves"),
    run(7, differs=(ENDS, "rest 2 of 4 is no longer reached", "a rest is new")),
)
FOUND = MutantRuns(ordered(RUNS), 7, 200, ("the cup is at its place",))


def test_what_nobody_notices_comes_first_and_what_alters_nothing_last():
    assert [each.line for each in FOUND.runs] == [4, 7, 3, 1, 2, 6, 5]


def test_the_order_is_the_same_whoever_was_done_first():
    assert all(ordered(each) == FOUND.runs for each in itertools.permutations(RUNS[:5] + RUNS[5:]))


def test_a_run_that_does_not_end_counts_for_both():
    assert summary_line(FOUND) == (
        "6 of 7 changes alter what the run brings about; success: notices 3 (50 %), the verdict 3, "
        "neither 2; 1 did not run to an end, which counts as noticed by both"
    )
    assert FOUND.share == pytest.approx(0.5)


def test_of_changes_that_alter_nothing_all_are_noticed():
    found = MutantRuns((RUNS[4],), 1, 1)
    assert found.share == 1.0
    assert render_mutants(found) == ""
    assert summary_line(found) == (
        "0 of 1 change alters what the run brings about; success: notices 0, the verdict 0, "
        "neither 0"
    )


def test_the_table_says_what_the_run_did_and_who_noticed():
    text = " ".join(render_mutants(FOUND, Paper(160)).split())
    assert "4 4 becomes -4 nothing cup ends 30 mm from where it ended" in text
    assert "cup ends 30 mm from where it ended; 2 more" in text
    assert "success, verdict" in text
    assert "complete: a motion ended before its goal" in text
    assert "6 6 becomes -6 no whole run stuck: nothing moves" in text
    assert "5 becomes" not in text


def test_places_name_their_file_where_there_are_several():
    found = MutantRuns((RUNS[3], replace(RUNS[3], file="poses.py")), 2, 2)
    assert "poses.py:4" in render_mutants(found)
    assert "pick.py:4" in render_mutants(found)
