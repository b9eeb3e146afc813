"""What lies between a controller and its cell: the time that messages and connections take."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.time.scheduler import CallTracer, Scheduler
from tracerisk.worlds.world import World

_LONG_PLANS = 0.75  # of the range of times that a plan takes: where long ones begin
_MOST_LOST = 20  # of one run: the first say what is wrong
_STEP_S = 0.004  # by how much sooner each further topic arrives where the order is reversed [s]


class Carrier:
    """Carries what controller and cell send each other, as long as the world says.

    What is carried between the same two ends arrives in the order in which it was sent. `lost` is
    what was sent to an end that was not connected yet: in words, and where.
    """

    def __init__(self, scheduler: Scheduler, tracer: CallTracer | Any, world: World) -> None:
        self.world = world
        self.lost: list[tuple[str, Location | None]] = []
        self._scheduler = scheduler
        self._tracer = tracer
        self._numbers = itertools.count()
        self._plans = itertools.count()
        self._arrived_ns: dict[Hashable, int] = {}
        self._places: dict[str, int] = {}

    def connected_ns(self, name: str, made_ns: int) -> int:
        """Return when two ends of a name are connected of which the later was made then [ns]."""
        return made_ns + self.world.drawn_ns(self.world.discovery_s, name)

    def note_lost(self, what: str, place: Location | None) -> None:
        """Note what of the controller's was sent to nobody."""
        if len(self.lost) < _MOST_LOST and (what, place) not in self.lost:
            self.lost.append((what, place))

    def lost_in(self, root: Path) -> list[tuple[str, str, int]]:
        """Return what was lost, each with its file below the root of the controller and line."""
        found = []
        for what, place in self.lost:
            if place is not None and Path(place.file).is_relative_to(root):
                file = Path(place.file).relative_to(root).as_posix()
                found.append((what, file, place.line or 0))
        return found

    def carry(
        self, deliver: Callable[[], object], name: str, ends: Hashable = (), *, is_away: bool = True
    ) -> None:
        """Deliver something of a name on behalf of the running code, after its time on the way.

        `ends` are who sends and who receives it. `is_away`: it goes from the controller to the
        cell or back, and not within either.
        """
        latency_ns = self._latency_ns(name) if is_away else 0
        if not latency_ns:
            deliver()
            return
        key, now_ns = (name, ends), self._scheduler.now_ns
        due_ns = self._arrived_ns[key] = max(now_ns + latency_ns, self._arrived_ns.get(key, 0))
        self.at(due_ns, deliver)

    def at(self, due_ns: int, act: Callable[[], object]) -> None:
        """Call `act` at a time [ns] on behalf of the code that runs now."""
        captured = None if self._tracer is None else self._tracer.capture()
        behalf: Any = nullcontext()
        if captured is not None and captured.frames:
            behalf = self._tracer.resume(captured)

        def call() -> None:
            with behalf:
                act()

        self._scheduler.call_at(due_ns, call)

    def pass_latency(self, name: str) -> None:
        """Wait while a call of a name, or its answer, is on its way."""
        if self._may_wait:
            self._pass_time(self._latency_ns(name))

    def pass_planning(self) -> None:
        """Wait while a plan is made."""
        if self._may_wait:
            self._pass_time(self.planning_ns())

    def planning_ns(self) -> int:
        """Return how long the next plan takes [ns]."""
        if not self.world.planning_s[1]:
            return 0
        low_s, high_s = self.world.planning_s
        number = next(self._plans)
        # A long one that a short one follows shows who counts on the time that it takes.
        middle_s = low_s + (high_s - low_s) * _LONG_PLANS
        within = (low_s, low_s + high_s - middle_s) if number % 2 else (middle_s, high_s)
        return self.world.drawn_ns(within, "plan", number)

    @property
    def _may_wait(self) -> bool:
        """Whether a thread of the controller runs; what runs in a kernel event never waits."""
        return self._scheduler.current is not None and not self._scheduler.in_kernel

    def _pass_time(self, duration_ns: int) -> None:
        if duration_ns:
            self._scheduler.pass_until(self._scheduler.now_ns + duration_ns)

    def _latency_ns(self, name: str) -> int:
        low_s, high_s = self.world.latency_s
        if not high_s:
            return 0
        if self.world.reverses_topics:
            place = self._places.setdefault(name, len(self._places))
            return round(max(low_s, high_s - _STEP_S * place) * 1e9)
        return self.world.drawn_ns((low_s, high_s), next(self._numbers))
