"""What a run in a world depends on, and how the lock keeps it."""

from tracerisk.common.worlds.world_run import (
    WorldRun,
    dependence_line,
    joined_worlds,
    kept_worlds,
    worlds_summary,
)
from tracerisk.errors import Location

SAME = WorldRun("latency", "complete")
LOST = WorldRun(
    "discovery",
    "complete",
    differs=("rest 1 of 2 is no longer reached", "rest 2"),
    cause="a message on /a is lost",
    location=Location("pick.py", 18),
)


def test_a_sentence_says_what_depends_on_a_world_why_and_where():
    assert dependence_line(LOST) == (
        "depends on world discovery (publishers, subscribers, services and actions take 0.2 to "
        "1 s to connect): rest 1 of 2 is no longer reached; a message on /a is lost (pick.py:18)"
    )


def test_the_lock_keeps_the_verdict_and_what_depends():
    kept = kept_worlds(worlds_summary([SAME, LOST]))
    assert [run.world for run in kept] == ["discovery", "latency"]
    assert [run.depends for run in kept] == [True, False]
    assert dependence_line(kept[0]) == dependence_line(LOST)


def test_nothing_is_kept_of_no_worlds():
    assert worlds_summary([]) == {}
    assert kept_worlds({}) == ()


def test_what_is_malformed_in_a_lock_is_left_out():
    data = {"latency": {"verdict": "complete"}, "start": 3, "order": {"verdict": ["x"]}}
    assert [run.world for run in kept_worlds({"worlds": data})] == ["latency"]


def test_runs_of_now_go_before_earlier_ones_of_the_same_world():
    now = WorldRun("latency", "faulted", "it fell")
    assert joined_worlds([SAME, LOST], [now]) == (LOST, now)
