"""What lies between a controller and its cell: the time that messages and connections take."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Callable, Hashable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from tracerisk.common.worlds.world import World
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.time.scheduler import CallTracer, Scheduler
from tracerisk.ros.world.connecting import ConnectionTimes, Early, EndKind, Work

_LONG_PLANS = 0.75  # of the range of times that a plan takes: where long ones begin
_MOST_LOST = 20  # of one run: the first say what is wrong
_STREAM_NS = 1_000_000_000  # who sends again within this time loses nothing
_STEP_S = 0.004  # by how much sooner each further topic arrives where the order is reversed [s]


class Carrier:
    """Carries what controller and cell send each other, as long as the world says.

    What is carried between the same two ends arrives in the order in which it was sent. `early` is
    what was sent to an end that was not connected yet; `times` say how long that takes where the
    world leaves it to the distribution.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        tracer: CallTracer | Any,
        world: World,
        times: ConnectionTimes | None = None,
    ) -> None:
        self.world = world
        self.early: list[Early] = []
        self.times = ConnectionTimes() if times is None else times
        self._joined_ns: defaultdict[NodeProcess | None, list[int]] = defaultdict(list)
        self._latest_ns = 0
        self._owed_ns = 0
        self._scheduler = scheduler
        self._tracer = tracer
        self._numbers = itertools.count()
        self._plans = itertools.count()
        self._arrived_ns: dict[Hashable, int] = {}
        self._places: dict[str, int] = {}

    # Connections

    def join(self) -> int:
        """Note that the process whose code runs makes the first node of a context (ROS 2).

        Returns when that is [ns], for `leave`.
        """
        self._joined_ns[self._scheduler.process].append(self._scheduler.now_ns)
        return self._scheduler.now_ns

    def leave(self, joined_ns: int) -> None:
        """Note that a context of the process whose code runs has ended."""
        self._joined_ns[self._scheduler.process].remove(joined_ns)

    def made_ns(self, *, by_controller: bool) -> int:
        """Return from when on an end that is made now looks for others [ns]."""
        now_ns = self._scheduler.now_ns
        if self.world.has_discovery:
            return now_ns
        if not by_controller:
            return 0  # the cell was there before
        if self.times.is_by_process and (joined := self._joined_ns[self._scheduler.process]):
            return joined[0]
        return now_ns

    def connected_ns(self, name: str, made_ns: int, kind: EndKind) -> int:
        """Return when an end of the controller's is connected with the cell's of a name [ns].

        `made_ns` is that of the one that was made later.
        """
        if self.world.has_discovery:
            return made_ns + self.world.drawn_ns(self.world.discovery_s, name)
        return made_ns + round(self.times.seconds(kind) * 1e9)

    def own_connected_ns(self, made_ns: int, kind: EndKind, *, is_within: bool = False) -> int:
        """Return when two ends of the controller and its companions are connected [ns].

        `is_within`: both are of one process.
        """
        if is_within and self.times.is_by_process:
            return 0
        return made_ns + round(self.times.seconds(kind) * 1e9)

    def expect(self, due_ns: int) -> None:
        """Note that two ends will be connected at a time [ns]."""
        self._latest_ns = max(self._latest_ns, due_ns)

    def pass_connections(self) -> None:
        """Wait until all ends are connected: what the controller does takes longer than that."""
        if self._scheduler.may_wait and self._scheduler.now_ns < self._latest_ns:
            self._scheduler.pass_until(self._latest_ns)

    def owe(self, work: Work) -> None:
        """Count the time of some work, in which nothing may wait, to the work that comes next."""
        if self._joined_ns[self._scheduler.process]:
            self._owed_ns += round(self.times.takes_s(work) * 1e9)

    def pass_work(self, work: Work) -> None:
        """Wait while the running code makes something, but no longer than until all is connected.

        Only then does it matter how long that takes.
        """
        self.owe(work)
        due_ns = min(self._scheduler.now_ns + self._owed_ns, self._latest_ns)
        self._owed_ns = 0
        if self._scheduler.may_wait and self._scheduler.now_ns < due_ns:
            self._scheduler.pass_until(due_ns)

    def note_early(
        self,
        what: str,
        name: str,
        kind: EndKind,
        content: object = None,
        *,
        is_kept: bool = False,
    ) -> None:
        """Note what of the controller's went to somebody that it was not connected to yet.

        `is_kept`: it waits for the connection.
        """
        if content is None and any(early.name == name for early in self.lost):
            return  # who asks after what was lost
        place = asking_place()
        now_ns = self._scheduler.now_ns
        known = [early for early in self.early if (early.what, early.place) == (what, place)]
        if known:
            known[0].last_ns, known[0].content = now_ns, content
            known[0].is_made_good = False
        elif len(self.early) < _MOST_LOST:
            self.early.append(Early(what, name, place, now_ns, now_ns, kind, is_kept, content))

    def note_in_time(self, name: str, content: object = None) -> None:
        """Note that something arrived: it makes good what was lost at its line just before.

        So does the same message whenever it is sent again there, and who finds a server at last.
        """
        opened = [early for early in self.early if early.name == name and not early.is_made_good]
        if not opened:
            return
        place, now_ns = asking_place(), self._scheduler.now_ns
        for early in opened:
            is_stream = early.place == place and now_ns - early.last_ns <= _STREAM_NS
            is_repeated = early.place == place and early.content == content
            if early.content is None or is_stream or is_repeated:
                early.is_made_good = True

    def note_delivered(self, topic: str) -> None:
        """Note that what a publisher kept has arrived."""
        for early in self.early:
            if early.is_kept and early.name == topic:
                early.is_made_good = True

    @property
    def lost(self) -> list[Early]:
        """What reached nobody, and was not made good."""
        return [early for early in self.early if not early.is_made_good]

    def lost_in(self, root: Path) -> list[tuple[str, str, int]]:
        """Return what was lost, each with its file below the root of the controller and line."""
        lost = []
        for early in self.early:
            place = early.place
            if early.is_kept and early.is_made_good:
                continue
            if place is not None and Path(place.file).is_relative_to(root):
                file = Path(place.file).relative_to(root).as_posix()
                lost.append((f"{early.what} is lost", file, place.line or 0))
        return lost

    # The way of what is sent

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
        if self._scheduler.may_wait:
            self._pass_time(self._latency_ns(name))

    def pass_planning(self) -> None:
        """Wait while a plan is made, which takes longer than a connection."""
        self.pass_connections()
        if self._scheduler.may_wait:
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
