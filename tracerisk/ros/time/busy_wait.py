"""The rule of busy waits: what asks again and again at one instant moves the clock by 1 ms.

Without it, a loop that only looks at the clock, or at a state that time alone changes, would
never end: virtual time stands still while a thread of the controller runs.
"""

from __future__ import annotations

from tracerisk.ros.controller.thread import ControllerThread

READ_STEP_NS = 1_000_000
"""How far a second reading of the clock at one instant moves it [ns]."""
CALLS_PER_INSTANT = 1000
"""Waits that need not wait, and locks that are free, that one thread gets at one instant."""
TURNS_PER_INSTANT = 2000
"""How often threads may hand the baton to each other at one instant."""
POLL_COST = 50
"""For how many such calls a turn of an event loop counts that finds nothing to wait for."""


def has_looked(thread: ControllerThread, now_ns: int) -> bool:
    """Return whether a thread has looked at this instant [ns] before."""
    return thread.read_ns == now_ns


def calls_are_spent(thread: ControllerThread, now_ns: int, cost: int) -> bool:
    """Count a call that need not wait; return whether a thread has made too many of them now."""
    if thread.calls_ns != now_ns:
        thread.calls, thread.calls_ns = 0, now_ns
    thread.calls += cost
    return thread.calls > CALLS_PER_INSTANT


class Turns:
    """The turns of one instant: threads that only hand on work take no time else."""

    def __init__(self) -> None:
        self._count = 0
        self._at_ns = -1

    def are_spent(self, now_ns: int) -> bool:
        """Count a turn at this instant [ns]; return whether there were too many."""
        if self._at_ns != now_ns:
            self._count, self._at_ns = 0, now_ns
        self._count += 1
        return self._count > TURNS_PER_INSTANT
