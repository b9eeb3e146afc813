"""When a controller only waits: in a loop of waits with limits, for what nobody provides.

`while not client.wait_for_service(timeout_sec=1.0)` and `while self.pose is None: sleep(0.1)` never
stand still, and end only with the duration of the run.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from tracerisk.errors import Location
from tracerisk.pipeline.run.needs.unmet_needs import UnmetNeeds
from tracerisk.pipeline.run.watching.run_watch import RunWatch
from tracerisk.ros.controller.frames import controller_stack
from tracerisk.ros.controller.thread import ControllerThread
from tracerisk.ros.time.scheduler import Scheduler

_WAITS_OF_A_LOOP = 3


@dataclass(slots=True)
class _Waits:
    """Where a thread has waited since the last command."""

    new_ns: int
    """When it last waited at a new place, in simulated time [ns]."""
    places: set[Any] = field(default_factory=set)
    """The stacks of the controller at which it waited."""
    count: int = 0
    """The number of waits since the last new place."""
    since: int = -1
    """The number of the last wait that was counted; -1 for none."""
    location: Location | None = None
    """The innermost place of the controller in the last new stack; `None` for none."""


@dataclass(slots=True, eq=False)
class StallWatch:
    """Ends a run in which every thread waits at the same places again and again.

    That is so where nothing was commanded for the `idle_s` of the watch, something that the
    controller asked for is not there, and the scenario has no more to give.
    """

    scheduler: Scheduler
    """The scheduler with the controller's threads and their waits."""
    watch: RunWatch
    """The watch with the time of the last command."""
    needs: UnmetNeeds
    """What the controller waits for in vain."""
    is_pending: Callable[[], bool]
    """Returns whether the scenario has more to give."""
    _waits: dict[int, _Waits] = field(default_factory=dict, init=False)
    """The waits of each thread, by its number."""

    def time_passed(self) -> None:
        """Look whether the controller only waits; called whenever the world has moved."""
        if self.scheduler.over is not None:
            return
        now_ns = self.scheduler.now_ns
        if self.watch.is_commanding or self.is_pending():
            self._waits.clear()
            return
        threads = [
            controller_thread
            for controller_thread in self.scheduler.threads
            if controller_thread.is_controllers
        ]
        for thread in threads:
            self._note(thread, now_ns)
        if now_ns - self.watch.last_event_ns < self.watch.idle_s * 1e9:
            return
        stalled = [thread for thread in threads if self._stalls(thread, now_ns)]
        if not stalled or any(
            controller_thread.wait is None or controller_thread.wait.deadline_ns is not None
            for controller_thread in threads
            if controller_thread not in stalled
        ):
            return
        unmet = self.needs.waited_for()
        if unmet:
            thread = stalled[0]
            place = self._waits[thread.number].location
            self.scheduler.end(
                "deadlock",
                f"{thread.name} has only waited for {self.watch.idle_s:g} s of simulated time, and "
                f"nothing provides {self.needs.listed(unmet)}",
                place or unmet[0].location,
            )

    def _note(self, thread: ControllerThread, now_ns: int) -> None:
        known = self._waits.get(thread.number)
        if known is None or known.new_ns < self.watch.last_event_ns:
            known = self._waits[thread.number] = _Waits(now_ns)
        wait = thread.wait
        if wait is None or wait.since == known.since:
            return
        known.since = wait.since
        stack = controller_stack(wait.frame)
        if stack not in known.places:
            known.places.add(stack)
            known.new_ns, known.count = now_ns, 0
            known.location = stack[-1][0] if stack else None
        known.count += 1

    def _stalls(self, thread: ControllerThread, now_ns: int) -> bool:
        known = self._waits[thread.number]
        if now_ns - known.new_ns < self.watch.idle_s * 1e9:
            return False
        wait = thread.wait
        is_lasting = wait is not None and wait.deadline_ns is None and wait.kind == "unmet"
        return is_lasting or known.count > _WAITS_OF_A_LOOP
