"""The same program under real rospy, with a real master, and under the stand-ins.

`test_live_run.py` compares `goals_and_services` on each run, these are for the slow one.
"""

import re
from pathlib import Path

import pytest

from tracerisk import api
from tracerisk.trace import Trace

PROGRAMS = Path(__file__).parent / "programs"
ON_THE_WALL_CLOCK = frozenset(
    {
        "goals_and_services",
        "wait_for_message",
        "wait_for_service",
        "shutdown",
        "preempt",
        "latched",
        "listeners",
    }
)
"""In these rospy itself waits on the wall clock, which must be no faster than simulated time."""
CUT_SHORT = frozenset({"preempt", "replaced_goal"})
"""In these a motion ends where the message finds it, a step of the clock sooner or later."""
SPEED = 5.0
STEP_S = 0.002
"""Between two samples of the twin [s]."""
REST_S = 0.02
"""Most that a joint rests between two goals of which one follows at the end of the other [s]. The
clock of a live run stands while the controller answers, so its motions may join there; a node on
the stand-ins takes a millisecond to answer, as real ones do, and the joint stops."""
LOST_TRANSITION = "Got a transition callback on a goal handle that we're not tracking"
"""What actionlib logs where it has lost its race: `send_goal` of its SimpleActionClient sends the
goal before it notes the handle, and a status that arrives in between is dropped for good."""
MOST_RACES = 4


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(each.stem for each in PROGRAMS.glob("*.py")))
def test_a_program_does_the_same_under_real_rospy(
    name: str, real_ros: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "pyproject.toml").touch()
    script = tmp_path / f"{name}.py"
    script.write_bytes((PROGRAMS / f"{name}.py").read_bytes())

    live, live_log = _without_race(script, capfd, 1.0 if name in ON_THE_WALL_CLOCK else SPEED)
    twin, printed = _traced(script, capfd, live_speed=None)
    twin_log = logged(printed)

    assert twin_log, "the program printed nothing to compare"
    assert live_log == twin_log
    assert_same(live, twin, near=0.01 if name in CUT_SHORT else 1e-3)


def assert_same(live: Trace, twin: Trace, *, near: float = 1e-3) -> None:
    """The same visits and moves, under real rospy and under the stand-ins."""
    assert live.is_measured
    assert not twin.is_measured
    assert live.end.cause == twin.end.cause, live.end.message
    assert _steps(live) == _steps(twin)
    # What is waited for in vain is followed by stand-ins alone.
    assert {r.code for r in live.verdict.reasons} <= {r.code for r in twin.verdict.reasons}
    if not twin.functions:
        return  # the arm holds still, for as long as the program lasts
    assert _active(live) == _active(twin)
    for element in _active(twin):
        ours, theirs = twin.active[element], live.active[element]
        # What begins or ends between two samples of the twin is a sample longer or shorter.
        step_s = 2.01 * STEP_S * max(ours.starts, 1)
        rest_s = REST_S * max(ours.starts - theirs.starts, 0)
        assert theirs.moving_s == pytest.approx(ours.moving_s, rel=1e-3, abs=step_s + rest_s), (
            element
        )
        # The mean load is one over the time in motion, which is longer by the rest between goals.
        of_load = max(near, rest_s / max(ours.moving_s, rest_s, STEP_S))
        assert theirs.torque_cubic == pytest.approx(ours.torque_cubic, rel=of_load, abs=1e-4), (
            element
        )
        if "/" in element or ours.borderline or theirs.borderline:
            continue  # a sensor; or whether it holds lies within a factor of two of the threshold
        # To find each other takes nodes a while, in which the arm holds still: on the stand-ins
        # the shortest that was measured, and here as long as the machine needs.
        later_s = abs(live.visits[0].start_s - twin.visits[0].start_s)
        most_s = later_s + 0.03 * ours.active_s + 10 * STEP_S
        assert abs(theirs.active_s - ours.active_s) <= most_s, element


def _without_race(
    script: Path, capfd: pytest.CaptureFixture[str], live_speed: float
) -> tuple[Trace, list[str]]:
    """Run under real rospy, again only where actionlib itself says that it dropped a status."""
    for _ in range(MOST_RACES):
        trace, printed = _traced(script, capfd, live_speed)
        if LOST_TRANSITION not in printed:
            break
    return trace, logged(printed)


def logged(printed: str) -> list[str]:
    return re.findall(r"^> .*$", printed, re.MULTILINE)


def _traced(
    script: Path, capfd: pytest.CaptureFixture[str], live_speed: float | None
) -> tuple[Trace, str]:
    controller = api.load_controller(script)
    settings = api.load_settings(controller, {"robot": "panda", "draft": False})
    trace = api.trace_controller(controller, settings, live_speed=live_speed)
    return trace, "".join(capfd.readouterr())


def _steps(trace: Trace) -> list[tuple[str, str]]:
    return [(visit.function.name, visit.outcome) for visit in trace.visits]


def _active(trace: Trace) -> set[str]:
    return {name for name, each in trace.active.items() if each.active_s > 0.0}
