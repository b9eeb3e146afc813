"""When a controller in another process is over, by what it sends and whether it waits."""

from typing import Any

import pytest

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.instrument.tracer import Frame
from tracerisk.pipeline.run.live.watch import HURRY_S, RemoteThreads
from tracerisk.pipeline.run.watching.run_watch import RunWatch
from tracerisk.pipeline.trace.run_files import IDLE_S

STEP_S = 0.5


class _Clock:
    now_ns = 0


def lived(*, sends: bool, waits_at_s: float | None) -> Any:
    """Return how a run without input is over, after twice the time that it may hurry."""
    clock = _Clock()
    threads = RemoteThreads(clock)  # type: ignore[arg-type]
    threads.stirred()
    for step in range(int(2 * HURRY_S / STEP_S)):
        clock.now_ns = int(step * STEP_S * 1e9)
        if sends:
            threads.stirred()
        threads.look_without_input(waits=step * STEP_S == waits_at_s)
    return threads.over


def test_a_menu_that_reads_nothing_and_sends_on_is_over():
    over = lived(sends=True, waits_at_s=None)
    assert over.cause == "idle"
    assert over.message == "its input has ended, and it has sent for 10 s without a wait"


@pytest.mark.parametrize(("sends", "waits_at_s"), [(False, None), (True, HURRY_S - 0.5)])
def test_a_node_that_waits_or_is_silent_goes_on(sends, waits_at_s):
    assert lived(sends=sends, waits_at_s=waits_at_s) is None


def watched(spins: Any, *, commands: bool = True, sends_at_s: float | None = None) -> Any:
    """Return how a run is over whose main thread spins alone at some seconds, and after how many.

    Its only command arrives at once; what it sends else is none.
    """
    clock = _Clock()
    threads = RemoteThreads(clock)  # type: ignore[arg-type]
    watch = RunWatch(threads, None)  # type: ignore[arg-type]
    main = Frame(FunctionRef("cell.cpp", QualifiedName("main")), 1, 1, (2, 0), "main")
    if commands:
        watch.issued(1, (main,), (0.5,))
        watch.ended(1, "arrived")
    for second in range(int(3 * IDLE_S)):
        clock.now_ns = int(second * 1e9)
        if second == sends_at_s:
            threads.stirred()
        threads.spins(alone=spins(second))
        watch.time_passed()
        if threads.over is not None:
            return threads.over.cause, second
    return None


def test_a_node_that_only_spins_is_over_after_the_time_that_a_loop_may_idle():
    assert watched(lambda _: True) == ("idle", IDLE_S)


@pytest.mark.parametrize("lasts_s", [15, IDLE_S + 15])
def test_a_callback_that_waits_for_long_is_waited_for(lasts_s):
    begins_s = 5
    ends_s = begins_s + lasts_s
    assert watched(lambda second: not begins_s <= second < ends_s) == ("idle", ends_s + IDLE_S)


@pytest.mark.parametrize(("sends_at_s", "cause"), [(None, "quiescent"), (5, "no_motion")])
def test_a_node_that_never_commanded_and_only_spins_comes_to_rest(sends_at_s, cause):
    over = watched(lambda _: True, commands=False, sends_at_s=sends_at_s)
    assert over == (cause, IDLE_S)
