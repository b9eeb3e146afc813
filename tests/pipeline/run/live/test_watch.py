"""When a controller in another process is over, by what it sends and whether it waits."""

from typing import Any

import pytest

from tracerisk.pipeline.run.live.watch import HURRY_S, RemoteThreads

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
