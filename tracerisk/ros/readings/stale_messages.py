"""Messages that a callback handles late, and moves the robot by, while newer ones wait behind them.

Only streams are looked at: each of several orders that wait is meant to be carried out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.topic_ends import Subscription

_OLD_NS = 1_000_000_000
"""A message that waited for so long is late: longer than a tracking arm needs for a short way."""
_NEWER = 3
"""Only where so many newer ones wait has the callback fallen behind for good."""
_STREAM_NS = 500_000_000
"""Messages that come no further apart than this are a stream, and no orders, which a user or
a planner of the shift sends."""

Waiting = Sequence[tuple[Any, int]]
"""Messages that wait, from the oldest on, each with when it came [ns]."""


@dataclass(slots=True)
class _Late:
    """How far a subscription has fallen behind."""

    remedy: str
    """The change to the program that would keep only the newest message."""
    begin_ns: int
    """The simulated time since which it is behind [ns]."""
    age_ns: int = 0
    """The greatest age of a message when it was handled [ns]."""
    newer: int = 0
    """The greatest number of newer messages that waited."""


class StaleMessages:
    """The late messages of a run by which something was commanded: `client(StaleMessages)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._late: dict[tuple[str, Location | None], _Late] = {}
        self._handled: list[tuple[Any, tuple[str, Location | None], _Late]] = []

    @contextmanager
    def handling(
        self,
        subscription: Subscription | None,
        message: Any,
        came_ns: int,
        waiting: Waiting,
        remedy: str,
    ) -> Iterator[None]:
        """Take what is commanded within the block, by its thread, for done after a message.

        `came_ns` is when it came, [ns]; `waiting` are those behind it; `remedy` says what the
        program does that handles the newest alone.
        """
        scheduler = self._runtime.scheduler
        age_ns = scheduler.now_ns - came_ns
        if subscription is None or age_ns < _OLD_NS or not waiting:
            yield
            return
        key = subscription.topic, subscription.place
        # One that has fallen behind still is while it works off the last of them.
        if key not in self._late and not _is_behind(message, came_ns, waiting):
            yield
            return
        entry = scheduler.current, key, _Late(remedy, scheduler.now_ns, age_ns, len(waiting))
        self._handled.append(entry)
        try:
            yield
        finally:
            self._handled.remove(entry)

    def commanded(self) -> None:
        """Note that the running code commands the robot."""
        if not self._handled:
            return
        thread = self._runtime.scheduler.current
        for handled_by, key, now in self._handled:
            if handled_by is thread:
                most = self._late.setdefault(key, _Late(now.remedy, now.begin_ns))
                most.age_ns = max(most.age_ns, now.age_ns)
                most.newer = max(most.newer, now.newer)

    def report(self) -> None:
        """Record a finding of each subscription whose late messages moved the robot."""
        for (topic, place), late in self._late.items():
            self._runtime.recorder.finding(
                "handled_late",
                f"what the callback of {topic} commanded came of messages up to "
                f"{late.age_ns / 1e9:.1f} s old, while up to {late.newer} newer ones waited; "
                f"{late.remedy} keeps the newest alone",
                place,
                object_name=topic,
                time_ns=late.begin_ns,
            )


def _is_behind(message: Any, came_ns: int, waiting: Waiting) -> bool:
    """Return whether many of a stream wait, of which the last says something else."""
    if len(waiting) < _NEWER:
        return False
    times = [came_ns, *(ns for _, ns in waiting)]
    steps = [later - earlier for earlier, later in pairwise(times)]
    # What comes at one time is a list of orders.
    is_stream = max(steps) <= _STREAM_NS <= times[-1] - times[0]
    return is_stream and _content(message) != _content(waiting[-1][0])


def _content(message: Any) -> list[Any]:
    """Return the fields of a message but its header, which says when it was made."""
    names = [name.lstrip("_") for name in type(message).__slots__]
    return [getattr(message, name) for name in names if name != "header"]
