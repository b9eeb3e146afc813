"""A stream of set points that leads nowhere else is cut long before its time is over."""

from dataclasses import dataclass, field
from math import sin
from types import SimpleNamespace

import pytest

from tracerisk.pipeline.run.watching.run_watch import RunWatch

PERIOD_NS = 5_000_000
FRAME = SimpleNamespace(function="step", site=0, instance=0, root="main", activation=1)


@dataclass
class Clock:
    """A scheduler of one thread that only tells the time, and takes note of the end."""

    now_ns: int = 0
    over: str | None = None
    said: str = ""
    threads: tuple = ()
    baton: SimpleNamespace = field(default_factory=lambda: SimpleNamespace(ident=lambda: 1))

    def end(self, cause, message, location=None):
        self.over, self.said = cause, message

    def raise_if_over(self):
        pass


def streamed(goal, *, cuts: bool, most: int = 30_000) -> tuple[Clock, int]:
    """Stream `goal(n)` until the run is cut; return the clock and the number of set points."""
    clock = Clock()
    watch = RunWatch(clock, SimpleNamespace(note=lambda *_, **__: None), cuts_streams=cuts)
    for number in range(most):
        watch.looped("c.py", 3)
        if clock.over is not None:
            return clock, number
        watch.issued(number, [FRAME], [goal(number), 0.0])
        watch.ended(number, "replaced")
        clock.now_ns += PERIOD_NS
    return clock, most


def test_a_stream_that_leads_nowhere_else_is_cut_and_says_how_much_was_carried_out():
    clock, count = streamed(lambda number: sin(number / 400), cuts=True)
    assert clock.over == "duration"
    assert count == 10_000
    assert "10000 set points" in clock.said


@pytest.mark.parametrize(
    ("goal", "cuts"),
    [
        pytest.param(lambda number: number / 1000, True, id="it leads on"),
        pytest.param(lambda number: sin(number / 400), False, id="somebody asked for the time"),
    ],
)
def test_other_streams_have_their_time(goal, cuts):
    clock, _ = streamed(goal, cuts=cuts, most=12_000)
    assert clock.over is None
