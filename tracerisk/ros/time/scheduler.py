"""Virtual time: the controller's threads, one at a time, and a world that moves while all wait.

Every thread of the controller is a real thread, or a greenlet (`baton.py`), and exactly one holds
the baton. It passes it on only where it waits, or reads the clock twice at one instant
(`busy_wait.py`). The thread that waits looks for who may run next: kernel events that are due, then
the thread that has waited longest among those whose wait is over, and where there is none it lets
the world move to the next instant at which something is due. So the order of everything depends on
simulated time and on sequence alone.

Times are integer nanoseconds of simulated time.
"""

from __future__ import annotations

import itertools
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import partial
from sys import _getframe
from typing import Any, Literal, NoReturn, TypeVar

from tracerisk.errors import Location
from tracerisk.ros.controller.exit_calls import ExitCalls
from tracerisk.ros.controller.needs import Need, NeedLedger
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.controller.programs import Awaited, Programs
from tracerisk.ros.controller.signals import Signals
from tracerisk.ros.controller.thread import (
    ControllerThread,
    HoldsLock,
    Meaning,
    RunOver,
    Wait,
    WaitKind,
)
from tracerisk.ros.time.baton import Baton, ThreadBaton
from tracerisk.ros.time.busy_wait import READ_STEP_NS, Turns, calls_are_spent, has_looked
from tracerisk.ros.time.event_queue import EventQueue, ScheduledCall
from tracerisk.ros.time.standstill import end_of_duration, end_of_standstill, wait_without_limit
from tracerisk.ros.time.world import CallTracer, World
from tracerisk.trace import EndCause

__all__ = [
    "CallTracer",
    "ControllerThread",
    "Meaning",
    "RunOver",
    "ScheduledCall",
    "Scheduler",
    "WaitKind",
    "World",
]

STREAM_PATIENCE_NS = 1_000_000_000
"""How long background events alone may go on before it is a standstill: what they bring may
satisfy a wait, or move a callback to act [ns]."""
RAISES_BEFORE_GIVING_UP = 1000
"""How often a thread may swallow the end of the run."""

Result = TypeVar("Result")


def _always(kind: WaitKind) -> Callable[[], Meaning]:
    meaning = Meaning(kind)
    return lambda: meaning


_MEANINGS: dict[WaitKind, Callable[[], Meaning]] = {
    "blocked": _always("blocked"),
    "idle": _always("idle"),
    "unmet": _always("unmet"),
}


class Scheduler:
    """The clock, the baton and the queue of events of one run.

    `world` moves while all wait, `duration_ns` is the simulated time after which the run is over.
    `baton` says what the controller's threads are made of: real threads, unless given.
    `tracer` gives new threads the stack of their creator.
    `listens` (an attribute, set by the graph) returns whether the controller listens to the world
    outside, so that a standstill is no hang. `failed_threads` names those that died of an error.
    `on_stuck` (an attribute) is called in the main thread when it has swallowed the end of the run
    a thousand times; it should end the process.
    `on_over` (an attribute) is called when the run is over before the controller has ended, and
    when its main program has failed, before its exit calls.
    `on_silence` (an attribute) is called when a program is waited for that has been silent for
    long, with how the run ends if it stays so, and with None once it is not waited for any more.
    `on_abort` (an attribute) is called where the process is to end at once.
    `process` (an attribute) is the companion whose code runs, None for the controller's;
    `has_companions` says that there may be any, and `on_process_change` is called at each change.
    """

    def __init__(
        self,
        world: World,
        *,
        duration_ns: int,
        tracer: CallTracer | None = None,
        baton: Baton | None = None,
    ) -> None:
        self.world = world
        self.baton: Baton = ThreadBaton() if baton is None else baton
        self.duration_ns = duration_ns
        self.tracer = tracer
        self.listens: Callable[[], bool] = lambda: False
        self.failed_threads: list[tuple[str, BaseException]] = []
        self.on_stuck: Callable[[RunOver], None] | None = None
        self._now_ns = 0
        self._sequence = itertools.count()
        self._thread_numbers = itertools.count()
        self._events = EventQueue()
        self._threads: list[ControllerThread] = []
        self._by_ident: dict[int, ControllerThread] = {}
        self._main: ControllerThread | None = None
        self._turns = Turns()
        self._kernel_depth = 0
        self._stirred_ns = 0
        self._over: RunOver | None = None
        self._fault: BaseException | None = None
        self.on_over: Callable[[], None] | None = None
        self.on_silence: Callable[[RunOver | None], None] = lambda _: None
        self.on_abort: Callable[[str, Location | None], NoReturn] | None = None
        self.when_alone: list[Callable[[], None]] = []
        self.has_companions = False
        self.process: NodeProcess | None = None
        self.on_process_change: Callable[[NodeProcess | None], None] | None = None
        self.exit_calls = ExitCalls()
        self.signals = Signals()
        self.needs = NeedLedger()
        self.programs = Programs()

    # Companions

    def bound(self, call: Callable[..., Result], *, asks: bool = False) -> Callable[..., Result]:
        """Return `call` such that it runs as code of the process that asks for this.

        Whoever calls it: with `asks`, what it commands there is the doing of the controller's code
        that did. Hooks of the twin are left unbound: they act for whoever calls them.
        """
        if not self.has_companions:
            return call
        process = self.process

        def run(*args: Any, **kwargs: Any) -> Result:
            if asks:
                self.ask(process)
            with self._within(process):
                return call(*args, **kwargs)

        return run

    def ask(self, process: NodeProcess | None) -> None:
        """Note that the code which runs asks something of a companion."""
        if process is None or process is self.process or self._kernel_depth:
            return
        if self.process is not None:
            process.asked_by = self.process.asked_by or process.asked_by
        elif self.tracer is not None:
            process.asked_by = self.tracer.capture().frames or process.asked_by

    @contextmanager
    def _within(self, process: NodeProcess | None) -> Iterator[None]:
        thread, before = self.current, self.process
        if process is before:
            yield
            return
        of_thread = None if thread is None else thread.process
        if thread is not None and not self._kernel_depth:
            thread.process = process
        self._enter(process)
        try:
            yield
        finally:
            if thread is not None and not self._kernel_depth:
                thread.process = of_thread
            self._enter(before)

    def _enter(self, process: NodeProcess | None) -> None:
        if process is not self.process:
            self.process = process
            if self.on_process_change is not None:
                self.on_process_change(process)

    # The clock

    @property
    def now_ns(self) -> int:
        """The simulated time [ns]; asking for it moves nothing."""
        return self._now_ns

    @property
    def over(self) -> RunOver | None:
        """How the run ended, or None while it goes on."""
        return self._over

    def read_clock(self) -> int:
        """Return the time as the controller reads it [ns]: 1 ms later at a second reading."""
        self.touch()
        return self._now_ns

    def touch(self) -> None:
        """Note that the controller looked at a state that only time changes.

        A second look at the same instant moves the clock by 1 ms and lets other threads and
        events have their turn, so that a busy wait ends.
        Threads that are not the controller's, and kernel events, move nothing.

        Raises:
            RunOver: the run is over.
        """
        thread = self.current
        if thread is None or self._kernel_depth or thread.is_undisturbed:
            return
        self._raise_if_over(thread)
        if has_looked(thread, self._now_ns):
            self._block(thread, None, self._now_ns + READ_STEP_NS, "the clock to move")
        thread.read_ns = self._now_ns

    def note_progress(self) -> None:
        """Note that the thread works on: its next look at the clock is no busy wait's."""
        if self.current is not None:
            self.current.read_ns = -1

    def count_call(self, cost: int = 1) -> None:
        """Note a call that could wait and need not; too many at one instant move the clock."""
        thread = self.current
        if thread is None or self._kernel_depth or self._over is not None:
            return
        if calls_are_spent(thread, self._now_ns, cost):
            self._block(thread, None, self._now_ns + READ_STEP_NS, "the clock to move")

    # Waiting

    def sleep(self, duration_ns: int) -> None:
        """Advance by `duration_ns`; zero or less only gives others their turn.

        Raises:
            RunOver: the run is over.
        """
        thread = self._require_current()
        if duration_ns <= 0:
            self.touch()
        else:
            thread.waits += 1
        self._block(thread, None, self._now_ns + max(duration_ns, 0), "time to pass")

    def give_way(self) -> None:
        """Give the other threads that can run at this instant their turn; no time passes.

        Raises:
            RunOver: the run is over.
        """
        thread = self._require_current()
        self._block(thread, None, self._now_ns, "other threads")

    def pass_until(self, time_ns: int) -> None:
        """Advance by the time that a call takes which is no wait of the controller's.

        Raises:
            RunOver: the run is over.
        """
        self._block(self._require_current(), None, time_ns, "a call to return")

    def wait_until(
        self,
        predicate: Callable[[], bool],
        *,
        timeout_ns: int | None = None,
        reason: str,
        kind: WaitKind | Callable[[], Meaning] = "blocked",
        on: HoldsLock | ControllerThread | None = None,
        need: Need | None = None,
        awaited: Awaited | None = None,
    ) -> bool:
        """Wait until `predicate` holds, and return whether it does; False after `timeout_ns`.

        `predicate` must change nothing and read no clock; it is asked whenever something has
        happened. `reason` says what the wait is for: `service /add (pkg/Add)`. `kind` says
        what it means if it never ends, or returns what it means when somebody asks; `on` is the
        lock or thread that could end it, `need` what of the world outside it is for, `awaited`
        what of the programs that the controller has started.

        Raises:
            RunOver: the run is over.
        """
        thread = self._require_current()
        self._raise_if_over(thread)
        is_deferred = awaited is not None and self.programs.have_been and not self._kernel_depth
        if not is_deferred and predicate():
            self.count_call()
            if need is not None:
                self.needs.meet(need)
            return True
        if need is not None:
            self.needs.miss(need, self._now_ns)
        if timeout_ns is not None and timeout_ns <= 0:
            self.touch()
            return predicate()
        if self._kernel_depth:
            raise RuntimeError(f"a kernel event cannot wait for {reason}")
        deadline_ns = None if timeout_ns is None else self._now_ns + timeout_ns
        thread.waits += 1
        is_met = self._block(thread, predicate, deadline_ns, reason, kind, on, awaited)
        if need is not None:
            if is_met:
                self.needs.meet(need)
            else:
                self.needs.miss(need, self._now_ns)
        return is_met

    def miss(self, need: Need) -> None:
        """Note that the code which runs asks for something that is not there."""
        self.needs.miss(need, self._now_ns)

    def call_at(
        self, time_ns: int, callback: Callable[[], None], *, background: bool = False
    ) -> ScheduledCall:
        """Run `callback` when the clock reaches `time_ns`; it must not wait.

        Background events (a sensor's stream) alone do not keep the run going for long.
        """
        sequence = next(self._sequence)
        callback = self.bound(callback)
        return self._events.add(ScheduledCall(time_ns, sequence, callback, background))

    def raise_if_over(self) -> None:
        """Raise the end of the run in a thread of the controller, once it is over.

        Raises:
            RunOver: the run is over.
        """
        thread = self.current
        if thread is not None:
            self._raise_if_over(thread)

    # Threads

    @property
    def current(self) -> ControllerThread | None:
        """The controller's thread that asks, or None in any other thread."""
        return self._by_ident.get(self.baton.ident())

    @property
    def threads(self) -> tuple[ControllerThread, ...]:
        """The threads that live, in the order in which they were started."""
        return tuple(self._threads)

    def spawn(
        self,
        target: Callable[[], object],
        name: str,
        *,
        daemon: bool = True,
        inherit: bool = True,
        is_controllers: bool = True,
        process: NodeProcess | Literal["inherited"] | None = "inherited",
    ) -> ControllerThread:
        """Start a thread under the baton; it first runs when the caller waits.

        It inherits the caller's stack of traced functions if `inherit`. `is_controllers` is
        False for threads of a client library, which wait for work all their life.
        `process` is whose code it runs, that of the caller's unless given.
        """
        thread = self._add_thread(name, daemon=daemon)
        thread.process = self.process if process == "inherited" else process
        thread.is_controllers = is_controllers and thread.process is None
        thread.wait = self._new_wait(None, self._now_ns, "its start", "blocked", None)
        captured = self.tracer.capture() if self.tracer is not None and inherit else None
        ident = self.baton.start(thread, lambda: self._run_thread(thread, target, captured))
        thread.ident = ident
        self._by_ident[ident] = thread
        return thread

    def run_main(self, main: Callable[[], Result]) -> Result:
        """Run `main` in the calling thread as the controller's main thread, and return its result.

        When it has returned or raised, threads that are no daemons are waited for and exit calls
        are run, as CPython does; then all other threads are ended.

        Raises:
            RunOver: the run was over before the controller ended by itself.
            BaseException: what left `main`.
        """
        if self._threads:
            raise RuntimeError("the controller runs already")
        thread = self._main = self._add_thread("MainThread", daemon=False)
        thread.is_main = True
        thread.ident = self.baton.take(thread)
        self._by_ident[thread.ident] = thread
        has_failed = False
        try:
            try:
                result = main()
            except RunOver:
                raise
            except BaseException as error:
                # A real Ctrl-C ends at once; rospy's interruption only derives from it.
                if type(error) is not KeyboardInterrupt:
                    if self.on_over is not None:
                        self.on_over()
                    is_exit = isinstance(error, SystemExit) and error.code in (None, 0)
                    has_failed = self._over is None and not is_exit
                    # However threads that live on may end, it is the error that is reported.
                    with suppress(RunOver) if has_failed else nullcontext():
                        self._finish_as_interpreter()
                raise
            self._finish_as_interpreter()
            return result
        finally:
            if self._over is None:
                self._over = RunOver("ended", "the controller ended")
            self._end_other_threads(thread)
            thread.finished = True
            self._threads.clear()
            self._by_ident.clear()
            if self._fault is not None:
                raise self._fault
            if self._over.cause != "ended" and not has_failed:
                raise self._over.again() from None

    def end(self, cause: EndCause, message: str, location: Location | None = None) -> None:
        """End the run: every thread's next wait raises `RunOver`."""
        if self._over is None:
            self._end_with(RunOver(cause, message, location))

    def abort(self, message: str, location: Location | None) -> NoReturn:
        """End the process at once, as C code does whose assertion fails.

        In the code of a companion that process alone.
        """
        if self.process is not None:
            raise SystemExit(message)
        if self.on_abort is not None:
            self.on_abort(message, location)
        self.end("raised", message, location)
        assert self._over is not None
        raise self._over.again()

    def _end_with(self, over: RunOver) -> None:
        self._over = over
        if self.on_over is not None:
            self.on_over()

    @contextmanager
    def kernel(self) -> Iterator[None]:
        """Mark code of ours in a controller's thread: it must not wait, and moves no clock."""
        self._kernel_depth += 1
        try:
            yield
        finally:
            self._kernel_depth -= 1

    @property
    def may_wait(self) -> bool:
        """Whether a thread of the controller runs; what runs in a kernel event never waits."""
        return self.current is not None and not self._kernel_depth

    # The baton

    def _add_thread(self, name: str, *, daemon: bool) -> ControllerThread:
        thread = ControllerThread(name, next(self._thread_numbers), daemon)
        self._threads.append(thread)
        return thread

    def _new_wait(
        self,
        predicate: Callable[[], bool] | None,
        deadline_ns: int | None,
        reason: str,
        kind: WaitKind | Callable[[], Meaning],
        on: HoldsLock | ControllerThread | None,
        awaited: Awaited | None = None,
    ) -> Wait:
        since = next(self._sequence)
        meaning = _MEANINGS[kind] if isinstance(kind, str) else kind
        return Wait(since, self._now_ns, predicate, deadline_ns, reason, meaning, on, awaited)

    def _require_current(self) -> ControllerThread:
        thread = self.current
        if thread is None:
            raise RuntimeError("only a thread of the controller can wait in virtual time")
        return thread

    def _block(
        self,
        thread: ControllerThread,
        predicate: Callable[[], bool] | None,
        deadline_ns: int | None,
        reason: str,
        kind: WaitKind | Callable[[], Meaning] = "blocked",
        on: HoldsLock | ControllerThread | None = None,
        awaited: Awaited | None = None,
    ) -> bool:
        self._raise_if_over(thread)
        wait = self._new_wait(predicate, deadline_ns, reason, kind, on, awaited)
        while True:
            wait.frame = _getframe(1)
            thread.wait = wait
            following = self._next_thread(thread)
            if following is not thread:
                self.baton.hand(thread, following)
            self._enter(thread.process)
            thread.wait = wait.frame = None
            self._raise_if_over(thread)
            if thread.interrupt is not None:
                interrupt, thread.interrupt = thread.interrupt, None
                raise interrupt
            if not thread.signals:
                return wait.satisfied
            # As PEP 475 has it: unless a handler raises, the wait goes on.
            self._handle_signals(thread)

    # Signals

    def send_signal(self, number: int, *, from_python: bool = False) -> bool:
        """Send the controller a signal of its own, which its main thread handles.

        `from_python`: as of `_thread.interrupt_main`, which no library in C notices. Returns False
        where nothing handles it and it is to end the process.
        """
        taken = None if from_python else self.signals.taken_by(number)
        if taken is not None:
            # A thread of the library does it, a moment later.
            self.call_at(self._now_ns, taken)
        handler, main = self.signals.handler(number), self._main
        if callable(handler) and main is not None:
            main.signals.append(partial(handler, number, _getframe(1)))
            if self.current is main and not self._kernel_depth:
                self._handle_signals(main)
            return True
        return taken is not None or from_python or handler is signal.SIG_IGN

    def _handle_signals(self, thread: ControllerThread) -> None:
        while thread.signals:
            thread.signals.pop(0)()

    def _next_thread(self, thread: ControllerThread | None) -> ControllerThread:
        """Return who runs next; `thread` waits, or is None where it has finished."""
        self._kernel_depth += 1
        try:
            while self._over is None:
                self._run_due_events()
                if self.over is not None:
                    break
                if self._turns.are_spent(self._now_ns):
                    self._pass_time(READ_STEP_NS)
                    continue
                ready = self._first_ready() or self._first_answered()
                if ready is not None:
                    if ready.is_controllers:
                        self._stirred_ns = self._now_ns
                    return ready
                self._pass_time()
        except BaseException as error:  # noqa: BLE001 - ours, not the controller's: kept for run_main
            self._fault = error
            self._over = RunOver("raised", f"the simulation failed: {error}")
        finally:
            self._kernel_depth -= 1
        return thread or self._next_to_end()

    def _run_due_events(self) -> None:
        while self._over is None and (callback := self._events.pop_due(self._now_ns)) is not None:
            callback()

    def _first_ready(self) -> ControllerThread | None:
        waiting = [(thread.wait.since, thread) for thread in self._threads if thread.wait]
        for _, thread in sorted(waiting, key=lambda pair: pair[0]):
            wait = thread.wait
            if wait is None:
                continue
            self._enter(thread.process)
            is_deferred = wait.awaited is not None and self.programs.have_been
            if not is_deferred and wait.predicate is not None and wait.predicate():
                wait.satisfied = True
                return thread
            if wait.deadline_ns is not None and wait.deadline_ns <= self._now_ns:
                return thread
            if thread.interrupt is not None or thread.signals:
                return thread
        return None

    def _first_answered(self) -> ControllerThread | None:
        """Return a thread that can go on for what a program has done, before time passes.

        It goes on when nothing else can: whether an answer is there earlier depends on the machine.
        """
        if not self.programs.have_been:
            return None
        waits = {thread: thread.wait for thread in self._threads if thread.wait is not None}
        awaited = {thread: wait.awaited for thread, wait in waits.items() if wait.awaited}
        if not awaited:
            return None

        def answered() -> ControllerThread | None:
            for thread in sorted(awaited, key=lambda thread: waits[thread].since):
                predicate = waits[thread].predicate
                self._enter(thread.process)
                if predicate is not None and predicate():
                    return thread
            return None

        is_due = any(wait.deadline_ns is not None for wait in waits.values())
        only = not (is_due or self._events.is_expecting or self.world.busy)
        silent: list[RunOver] = []

        def tell() -> None:
            silent.append(wait_without_limit(awaited))
            self.on_silence(silent[0])

        self.programs.wait(awaited, lambda: answered() is not None, only=only, on_silence=tell)
        if silent:
            self.on_silence(None)
        first = answered()
        if first is not None:
            waits[first].satisfied = True
        return first

    def _pass_time(self, at_most_ns: int | None = None) -> None:
        deadlines = [
            thread.wait.deadline_ns
            for thread in self._threads
            if thread.wait is not None and thread.wait.deadline_ns is not None
        ]
        if at_most_ns is not None:
            later = [due_ns for due_ns in deadlines if due_ns > self._now_ns]
            deadlines = [*later, self._now_ns + at_most_ns]
        next_event_ns = self._events.next_ns
        if deadlines or self._events.is_expecting or self.world.busy:
            self._stirred_ns = self._now_ns
        elif next_event_ns is None or self._now_ns - self._stirred_ns >= STREAM_PATIENCE_NS:
            self._end_with(end_of_standstill(self._threads, listens=self.listens()))
            return
        if next_event_ns is not None:
            deadlines.append(next_event_ns)
        self._advance(min([*deadlines, self.duration_ns]))
        if self._now_ns >= self.duration_ns:
            self._end_with(end_of_duration(self._main, self.duration_ns))

    def _advance(self, target_ns: int) -> None:
        before_ns = self.world.time_ns
        reached_ns = target_ns
        if before_ns < target_ns:
            reached_ns = self.world.advance(target_ns)
            if reached_ns <= before_ns:
                raise RuntimeError(f"the world does not move beyond {reached_ns} ns")
        self._now_ns = max(self._now_ns, min(reached_ns, target_ns))

    def outlast(self) -> None:
        """End what is under way in the world when the controller is gone; no thread runs.

        What is in `when_alone` is called at first, and whenever a motion has ended.
        """
        for notify in self.when_alone:
            notify()
        while self.world.busy and self._now_ns < self.duration_ns:
            self._advance(self.duration_ns)
            for notify in self.when_alone:
                notify()

    # Ends

    def _raise_if_over(self, thread: ControllerThread) -> None:
        if self._over is None:
            return
        thread.raises += 1
        if thread.raises > RAISES_BEFORE_GIVING_UP:
            if not thread.is_main:
                self._abandon(thread)
            elif self.on_stuck is not None:
                self.on_stuck(self._over)
        raise self._over.again()

    def _abandon(self, thread: ControllerThread) -> None:
        # It swallows every end it is given: it gets no baton again, and dies with the process.
        self._remove(thread)
        self.baton.hand_for_good(thread, self._next_to_end())

    def _next_to_end(self) -> ControllerThread:
        for thread in self._threads:
            if not thread.is_main:
                return thread
        if self._main is None:
            raise RuntimeError("no thread is left")
        return self._main

    def _end_other_threads(self, main: ControllerThread) -> None:
        while len(self._threads) > 1:
            self.baton.hand(main, self._next_to_end())
            self._enter(main.process)

    def _finish_as_interpreter(self) -> None:
        """Do what CPython does between the end of the main module and its own."""
        self.exit_calls.run_before_joining()
        while lasting := [
            controller_thread
            for controller_thread in self._threads
            if not controller_thread.daemon
            and not controller_thread.is_main
            and controller_thread.process is None
        ]:
            thread = lasting[0]
            self.wait_until(
                lambda thread=thread: thread.finished,  # type: ignore[misc]
                reason=f"the end of thread {thread.name}",
                on=thread,
            )
        self.exit_calls.run_at_exit()

    def _run_thread(
        self, thread: ControllerThread, target: Callable[[], object], captured: Any
    ) -> None:
        self._enter(thread.process)
        thread.wait = None
        try:
            if self._over is None:
                context = (
                    self.tracer.resume(captured)
                    if self.tracer is not None and captured is not None
                    else nullcontext()
                )
                with context:
                    target()
        except RunOver:
            pass
        except SystemExit:
            pass
        except BaseException as error:  # noqa: BLE001 - printed as the interpreter prints it
            self.failed_threads.append((thread.name, error))
            threading.excepthook(
                threading.ExceptHookArgs((type(error), error, error.__traceback__, None))
            )
        finally:
            self._forget_dummy_thread()
            self._remove(thread)
            self.baton.leave(thread, self._next_thread(None))

    def _remove(self, thread: ControllerThread) -> None:
        thread.finished = True
        self._threads.remove(thread)
        if thread.ident is not None:
            self._by_ident.pop(thread.ident, None)
        for callback in thread.at_finish:
            callback()

    def _forget_dummy_thread(self) -> None:
        # `threading.current_thread()` leaves an entry for a thread that it did not start.
        known: dict[int, threading.Thread] = threading._active  # type: ignore[attr-defined]
        ident = self.baton.ident()
        if isinstance(known.get(ident), threading._DummyThread):
            del known[ident]
