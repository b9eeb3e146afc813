"""When a run without an end of its own is over: it repeats itself, or only idles.

See docs/theory.md#when-a-run-ends.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Sequence

from tracerisk.errors import Location
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import is_near
from tracerisk.instrument.tracer import Frame
from tracerisk.pipeline.run.watching.loops import (
    CYCLES_SEEN,
    SAME_GOAL,
    Iteration,
    Loop,
    cycle_start,
    ends_of,
    follow,
    is_same_cycle,
)
from tracerisk.pipeline.trace.run_files import CYCLE, IDLE_S, MISSION_END
from tracerisk.ros.scenario.schedule import Schedule
from tracerisk.ros.time.scheduler import ControllerThread, Scheduler
from tracerisk.trace import CommandEnd

_MOST_SET_POINTS = 10_000  # of a stream that leads nowhere else
_MANY_THE_SAME = 5000  # of so many that command the same a third of the idle time is enough


class RunWatch:
    """Watches commands and loops of a run, and ends it where nothing new will come.

    `schedule` (an attribute) is that of the scenario: while it has more to give, a run goes on.
    A loop is idle in which nothing was commanded for `idle_s` [s]. A stream of set points is cut
    before the time of the run is over where `cuts_streams`, for nobody asked for that time.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        recorder: Recorder,
        idle_s: float = IDLE_S,
        *,
        cuts_streams: bool = False,
    ) -> None:
        self.idle_s = idle_s
        self._cuts_streams = cuts_streams
        self._scheduler = scheduler
        self._recorder = recorder
        self.schedule: Schedule | None = None
        self._loops: dict[tuple[int, str, int], Loop] = {}
        self._callbacks: Loop | None = None
        self._iteration_of: dict[int, list[Iteration]] = {}
        self._last_command_ns: int | None = None
        self._idle_ns: int | None = None
        self._spin: object = None
        self._spin_ns = 0

    def looped(self, file: str, line: int) -> None:
        """Note that an iteration of an endless loop begins."""
        now_ns, thread = self._scheduler.now_ns, self._scheduler.baton.ident()
        key = (thread, file, line)
        loop = self._loops.pop(key, None)
        if loop is None:
            loop = Loop(thread, Location(file, line), now_ns)
        elif loop.current.ways:
            self._close(loop, now_ns)
        # The last of the table is the innermost of those that run.
        self._loops[key] = loop
        loop.begin(now_ns)
        self._scheduler.raise_if_over()

    def before_command(self, stack: Sequence[Frame]) -> None:
        """Note that a command is about to be issued, while callbacks may have repeated."""
        root = stack[0]
        if root.root in (None, "main", "thread"):
            return
        if not self._main_spins() and not self._main_leaves_it_to_callbacks():
            return
        now_ns = self._scheduler.now_ns
        loop = self._callbacks
        if loop is None:
            loop = self._callbacks = Loop(0, None, now_ns, root.activation)
            loop.begin(now_ns)
        if loop.root != root.activation:
            loop.root = root.activation
            if loop.current.ways:
                self._close(loop, now_ns)
            loop.begin(now_ns)
            self._scheduler.raise_if_over()

    def issued(self, command_id: int, stack: Sequence[Frame], goal: Sequence[float]) -> None:
        """Note that a command is issued that leads to `goal`."""
        self._last_command_ns = self._scheduler.now_ns
        way = tuple((frame.function, frame.site, frame.instance) for frame in stack)
        is_callback = stack[0].root not in (None, "main", "thread")
        main = self._main()
        thread: int | None = self._scheduler.baton.ident()
        if stack[0].root == "main" and main is not None:
            # The call of a service is carried out by another thread than the one that called.
            thread = main.ident
        loops = [loop for loop in self._loops.values() if loop.thread == thread]
        if is_callback and self._callbacks is not None:
            loops.append(self._callbacks)
        for loop in loops:
            current = loop.current
            is_another = not current.ways or current.ways[-1] != way
            if is_another:
                current.ways.append(way)
            if is_another or not is_near(current.goals[-1], goal, SAME_GOAL):
                current.goals.append(tuple(goal))
        self._iteration_of[command_id] = [loop.current for loop in loops]

    def ended(self, command_id: int, end: CommandEnd) -> None:
        """Note that a command ends, and how."""
        self._last_command_ns = self._scheduler.now_ns
        for iteration in self._iteration_of.pop(command_id, ()):
            iteration.has_failed |= end not in ("arrived", "replaced")
            if end == "arrived" and not iteration.has_reached:
                iteration.has_reached = True
                insort(iteration.of_loop.reached, iteration.number)

    @property
    def has_commanded(self) -> bool:
        """Whether anything was commanded yet."""
        return self._last_command_ns is not None

    @property
    def last_command_ns(self) -> int | None:
        """When something was commanded last [ns]; None before the first time."""
        return self._last_command_ns

    @property
    def is_commanding(self) -> bool:
        """Whether a command is live."""
        return bool(self._iteration_of)

    @property
    def last_event_ns(self) -> int:
        """When a command began or ended last, or the scenario acted [ns]."""
        acted_ns = 0 if self.schedule is None else self.schedule.last_ns
        return max(self._last_command_ns or 0, acted_ns)

    @property
    def _is_expecting(self) -> bool:
        return self.schedule is not None and self.schedule.is_pending

    def time_passed(self) -> None:
        """Look whether the controller only idles; called whenever the world has moved."""
        since_ns = self._idle_ns = self._idle_since_ns()
        now_ns = self._scheduler.now_ns
        if since_ns is None or now_ns - since_ns < self.idle_s * 1e9:
            return
        if self._scheduler.over is not None:
            return
        loop = self._innermost_of_main()
        place = loop.place if loop is not None and not self._main_spins() else None
        if self._last_command_ns is None:
            self._scheduler.end(
                "no_motion",
                f"a loop without an end, in which nothing was commanded for {self.idle_s:g} s of "
                "simulated time",
                place,
            )
            return
        self._scheduler.end(
            "idle",
            f"nothing more was commanded in {self.idle_s:g} s of a loop without an end",
            place,
        )

    def run_over(self, cause: str) -> None:
        """Note when the mission was over, at the end of a run that had nothing left to do."""
        # By now the threads unwind: what was seen when the world last moved is what counts.
        if cause in ("idle", "quiescent") and self._idle_ns is not None:
            self._recorder.note(MISSION_END, ns=self._idle_ns)

    def _idle_since_ns(self) -> int | None:
        """Return since when nothing is under way and the main thread only waits or loops."""
        if self._iteration_of or self._is_expecting:
            return None
        loop = self._innermost_of_main()
        if self._main_spins():
            quiet_ns = self._spin_ns
        elif loop is not None and not loop.current.ways:
            quiet_ns = loop.quiet_ns
        else:
            return None
        return max(quiet_ns, self.last_event_ns)

    def _innermost_of_main(self) -> Loop | None:
        main = self._main()
        if main is None:
            return None
        loops = [loop for loop in self._loops.values() if loop.thread == main.ident]
        return loops[-1] if loops else None

    def _main(self) -> ControllerThread | None:
        return next((thread for thread in self._scheduler.threads if thread.is_main), None)

    def _main_leaves_it_to_callbacks(self) -> bool:
        """Return whether the main thread loops without an end, and has never commanded anything."""
        loop = self._innermost_of_main()
        if loop is None or loop.thread == self._scheduler.baton.ident():
            return False
        return not loop.past and not loop.current.ways

    def _main_spins(self) -> bool:
        main = self._main()
        # A main thread that waits for the end of the one that spins spins as well.
        while main is not None and main.wait is not None and main.wait.deadline_ns is None:
            if not isinstance(main.wait.on, ControllerThread):
                break
            main = main.wait.on
        wait = main.wait if main is not None else None
        is_idle = wait is not None and wait.kind == "idle" and wait.deadline_ns is None
        if main is not None and main.spins_since_ns is not None and (wait is None or is_idle):
            # It runs the callbacks itself, and waits anew after each.
            self._spin, self._spin_ns = main, main.spins_since_ns
            return True
        if not is_idle:
            self._spin = None
            return False
        if self._spin is not wait:
            self._spin, self._spin_ns = wait, self._scheduler.now_ns
        return True

    def _close(self, loop: Loop, now_ns: int) -> None:
        """Close an iteration that commanded something, and end the run at the third cycle.

        What is commanded again and again and never arrives, replaced by the next say, is no cycle:
        such a run ends once it has gone on for as long as a loop may idle.
        """
        loop.past.append(loop.current)
        loop.quiet_ns = now_ns
        # Beside the first of them: what creeps on differs little from the one before.
        if not is_same_cycle(loop.past[-1:], loop.past[loop.same_from : loop.same_from + 1]):
            loop.same_from = loop.current.number
        follow(loop)
        if self._scheduler.over is not None or self._is_expecting:
            return
        pair = cycle_start(loop.past, loop.reached)
        if pair is not None:
            start, seen = pair
            self._recorder.note(CYCLE, start_ns=loop.past[start].start_ns, seen=seen)
            self._scheduler.end(
                "cycles",
                f"the same cycle came {seen} times in a loop without an end",
                loop.place,
            )
        elif self._never_arrives(loop, now_ns):
            lasting_s = (now_ns - loop.past[loop.same_from].start_ns) * 1e-9
            self._scheduler.end(
                "idle",
                f"nothing but the same was commanded in {lasting_s:.0f} s of a loop without an "
                f"end, and {ends_of(loop)}",
                loop.place,
            )
        elif self._cuts_streams and self._goes_on_and_on(loop, now_ns):
            count = len(loop.past) - loop.stream_from
            self._scheduler.end(
                "duration",
                f"{count} set points of a loop without an end were carried out, and since the "
                f"first {loop.led_on - loop.stream_from + 1} none led beyond where it had been",
                loop.place,
            )

    def _goes_on_and_on(self, loop: Loop, now_ns: int) -> bool:
        """Return whether a loop has given very many set points, and led nowhere else for long."""
        count = len(loop.past) - loop.stream_from
        if count < _MOST_SET_POINTS or 2 * (loop.led_on - loop.stream_from) > count:
            return False
        return now_ns - loop.past[loop.stream_from].start_ns >= self.idle_s / 3 * 1e9

    def _never_arrives(self, loop: Loop, now_ns: int) -> bool:
        """Return whether a loop has long commanded the same, and none of it has arrived."""
        count = len(loop.past) - loop.same_from
        if count < CYCLES_SEEN or (loop.reached and loop.reached[-1] >= loop.same_from):
            return False
        lasting_s = (now_ns - loop.past[loop.same_from].start_ns) * 1e-9
        return lasting_s >= (self.idle_s if count < _MANY_THE_SAME else self.idle_s / 3)
