"""Executors: what runs the callbacks of nodes, and in which thread."""

from __future__ import annotations

import inspect
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from tracerisk.ros.controller.thread import ControllerThread, WaitKind, spinning
from tracerisk.ros.imports.exported import defined as _defined

from ._run import run
from .context import Context
from .task import Future, Task

POOL_SIZE = 4
"""Threads of a MultiThreadedExecutor that is given no number; the real one counts processors."""


class TimeoutException(Exception):
    """Nothing was ready in time."""


class ShutdownException(Exception):
    """The executor was shut down."""


class ExternalShutdownException(Exception):
    """The context was shut down while the executor waited."""


class ConditionReachedException(Exception):
    """What the executor was to wait for has come."""


class TimeoutObject:
    """A timeout that can be changed [s]."""

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout


async def await_or_execute(callback: Any, *args: Any) -> Any:
    """Call a function, or await a coroutine function."""
    if inspect.iscoroutinefunction(callback):
        return await callback(*args)
    return callback(*args)


class Executor:
    """Base of the executors; one of its own has to define `_spin_once_impl`."""

    def __init__(self, *, context: Context | None = None) -> None:
        self._run = run()
        self._context = self._run.default_context if context is None else context
        self._nodes: list[Any] = []
        self._tasks: list[Task] = []
        self._batch: deque[Any] = deque()
        self._is_shutdown = False
        self._spinners: list[ControllerThread | None] = []
        self._n_waiting = 0

    @property
    def context(self) -> Context:
        """The context that the executor lives in."""
        return self._context

    def create_task(self, callback: Any, *args: Any, **kwargs: Any) -> Task:
        """Run a function or a coroutine in the executor; the task is its future.

        It inherits the stack of the code that creates it.
        """
        tracer = self._run.tracer
        stack = None if tracer is None else tracer.resume(tracer.capture())
        task = Task(callback, args, kwargs, executor=self, stack=stack)
        self._tasks.append(task)
        return task

    def _create_callback_task(self, callback: Any, *args: Any) -> None:
        """Run a callback of the library's own code, as a root."""
        tracer = self._run.tracer
        stack = None if tracer is None else tracer.root("callback")
        self._tasks.append(Task(callback, args, executor=self, stack=stack))

    def _create_done_task(self, callback: Any, future: Future) -> None:
        # Callbacks of a future are called by no code of the controller's.
        tracer = self._run.tracer
        stack = None if tracer is None else tracer.root("done_callback")
        self._tasks.append(Task(callback, (future,), executor=self, stack=stack))

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Run no more callbacks; those that run go on."""
        self._is_shutdown = True
        self._nodes.clear()
        self._batch.clear()
        return True

    def add_node(self, node: Any) -> bool:
        """Run the callbacks of a node too; False where the executor does already."""
        if node in self._nodes:
            return False
        self._nodes.append(node)
        node.executor = self
        return True

    def remove_node(self, node: Any) -> None:
        """Run the callbacks of a node no longer."""
        if node in self._nodes:
            self._nodes.remove(node)

    def wake(self) -> None:
        """Look for work again; the executor sees for itself what is new."""

    def get_nodes(self) -> list[Any]:
        """Return the nodes."""
        return list(self._nodes)

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down."""
        scheduler = self._run.scheduler
        with spinning(scheduler.current, scheduler.now_ns), self._spun():
            while self._context.is_valid and not self._is_shutdown:
                self.spin_once()

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until a future is complete, or for `timeout_sec` seconds."""
        with self._spun():
            if timeout_sec is None or timeout_sec < 0:
                while self._goes_on(future):
                    self._spin_once_impl(None, future)
                return
            scheduler = self._run.scheduler
            end_ns = scheduler.now_ns + round(timeout_sec * 1e9)
            while self._goes_on(future):
                self._spin_once_impl(max(0, end_ns - scheduler.now_ns), future)
                if scheduler.now_ns >= end_ns:
                    return

    def _goes_on(self, future: Future) -> bool:
        return self._context.is_valid and not future._done and not self._is_shutdown

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback, waiting for it `timeout_sec` seconds, or for ever."""
        with self._spun():
            self._spin_once_impl(_nanoseconds(timeout_sec), None)

    def spin_once_until_future_complete(
        self, future: Future, timeout_sec: float | TimeoutObject | None = None
    ) -> None:
        """Run one callback, or none if the future is complete before there is one."""
        seconds = timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
        with self._spun():
            self._spin_once_impl(_nanoseconds(seconds), future)

    def _spin_once_impl(self, timeout_ns: int | None, future: Future | None) -> None:
        raise NotImplementedError

    # Who spins

    @contextmanager
    def _spun(self) -> Iterator[None]:
        """Mark, while it lasts, that the calling thread runs the callbacks."""
        thread = self._run.scheduler.current
        self._spinners.append(thread)
        try:
            yield
        finally:
            self._spinners.remove(thread)

    def _is_spun_beside(self, thread: ControllerThread | None) -> bool:
        """Return whether another thread than this one runs the callbacks."""
        return any(each is not thread for each in self._spinners)

    @property
    def _takes_work(self) -> bool:
        """Whether a callback that becomes ready is run, or has to wait until others return."""
        return self._n_waiting > 0

    # Finding work

    def _next_task(self, timeout_ns: int | None, future: Future | None) -> Task | None:
        """Wait for work and return it; None after the timeout, or where there is to be none.

        Raises:
            ExternalShutdownException: the context was shut down.
        """
        scheduler = self._run.scheduler
        scheduler.count_call()
        deadline_ns = None if timeout_ns is None else scheduler.now_ns + timeout_ns
        while True:
            if self._is_shutdown or (future is not None and future._done):
                return None
            if not self._context.is_valid:
                raise ExternalShutdownException
            task = self._from_batch()
            if task is not None:
                return task
            self._batch.extend(self._ready())
            if self._batch:
                continue
            left_ns = None if deadline_ns is None else max(0, deadline_ns - scheduler.now_ns)
            if not self._wait(left_ns, future):
                return None

    def wait_for_ready_callbacks(
        self,
        timeout_sec: float | TimeoutObject | None = None,
        nodes: list[Any] | None = None,
        condition: Callable[[], bool] = lambda: False,
    ) -> tuple[Task, Any, Any]:
        """Wait for work, and return what does it, the entity that it is of and the entity's node.

        For an executor of the program's own, which calls what it is given. The last two are None
        where the work is that of a task; `nodes` changes nothing.

        Raises:
            TimeoutException: nothing was ready in time.
            ConditionReachedException: `condition` holds.
            ShutdownException: the executor was shut down.
            ExternalShutdownException: the context was.
        """
        seconds = timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
        if self._is_shutdown:
            raise ShutdownException
        with self._spun():
            task = None if condition() else self._next_task(_nanoseconds(seconds), None)
        if task is not None:
            return task, task._entity, task._node
        if self._is_shutdown:
            raise ShutdownException
        raise ConditionReachedException if condition() else TimeoutException

    def _wait_for_ready_callbacks(self, *args: Any, **kwargs: Any) -> Iterator[Any]:
        while True:
            yield self.wait_for_ready_callbacks(*args, **kwargs)

    def _from_batch(self) -> Task | None:
        while self._batch:
            work = self._batch.popleft()
            if isinstance(work, Task):
                if work.is_ready:
                    return work
            elif self._can_run(work):
                return self._task_of(work)
        return None

    def _ready(self) -> list[Any]:
        """Return tasks that go on, then entities that have work, in the order of rclpy."""
        self._tasks = [task for task in self._tasks if not task._done and not task._cancelled]
        found: list[Any] = [task for task in self._tasks if self._goes_on_with(task)]
        for node in self._nodes:
            found.extend(each for each in node._waitables if self._can_run(each))
        for node in self._nodes:
            found.extend(each for each in node._entities() if self._can_run(each))
        return found

    def _goes_on_with(self, task: Task) -> bool:
        # A coroutine of a node that has left is not resumed.
        return task.is_ready and (task._node is None or task._node in self._nodes)

    def _can_run(self, entity: Any) -> bool:
        return (
            not entity._is_taken
            and not entity._is_destroyed
            and entity._is_ready()
            and entity.callback_group.can_execute(entity)
        )

    def _has_work(self) -> bool:
        if any(self._goes_on_with(task) for task in self._tasks):
            return True
        return any(
            self._can_run(entity)
            for node in self._nodes
            for entity in (*node._waitables, *node._entities())
        )

    def _wait(self, timeout_ns: int | None, future: Future | None) -> bool:
        """Wait until there is work; False after the timeout."""
        scheduler = self._run.scheduler
        kind, reason = _what_is_waited_for(future)
        due = [
            entity._due_ns
            for node in self._nodes
            for entity in node._timers
            if entity._due_ns is not None
            and not entity._is_taken
            and entity.callback_group.can_execute(entity)
        ]
        alarm = scheduler.call_at(min(due), _nothing) if due else None
        # A node, a timer or a task that is made meanwhile has to be looked at.
        known = self._work_known()
        self._n_waiting += 1
        try:
            return scheduler.wait_until(
                lambda: (
                    self._is_shutdown
                    or not self._context.is_valid
                    or (future is not None and future._done)
                    or self._work_known() != known
                    or self._has_work()
                ),
                timeout_ns=timeout_ns,
                reason=reason,
                kind=kind,
            )
        finally:
            self._n_waiting -= 1
            if alarm is not None:
                alarm.cancel()

    def _work_known(self) -> tuple[Any, ...]:
        return (
            len(self._tasks),
            *(
                timer._due_ns
                for node in self._nodes
                for timer in node._timers
                if timer.callback_group.can_execute(timer)
            ),
        )

    def _task_of(self, entity: Any) -> Task:
        entity._is_taken = True
        tracer = self._run.tracer
        stack = None if tracer is None else tracer.root(entity._root_kind)
        task = Task(self._handle, (entity,), executor=self, stack=stack)
        task._entity, task._node = entity, entity._node
        self._tasks.append(task)
        return task

    async def _handle(self, entity: Any) -> None:
        group = entity.callback_group
        if self._is_shutdown or entity._is_destroyed or not group.beginning_execution(entity):
            entity._is_taken = False
            return
        try:
            call = entity._take(self)
            entity._is_taken = False
            if call is not None:
                await call()
        finally:
            group.ending_execution(entity)

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, *error: object) -> None:
        self.shutdown()


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins."""

    def _spin_once_impl(self, timeout_ns: int | None, future: Future | None) -> None:
        task = self._next_task(timeout_ns, future)
        if task is None:
            return
        task()
        error = task.exception()
        if error is not None:
            raise error


class MultiThreadedExecutor(Executor):
    """Runs callbacks in a pool of threads."""

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        if num_threads == 1:
            warnings.warn(
                "MultiThreadedExecutor is used with a single thread.\n"
                "Use the SingleThreadedExecutor instead.",
                stacklevel=2,
            )
        self._n_threads = POOL_SIZE if num_threads is None else num_threads
        self._n_running = 0
        self._submitted: deque[Task] = deque()
        self._futures: list[Task] = []
        self._pool: list[ControllerThread] = []

    def shutdown(self, timeout_sec: float | None = None, *, wait_for_threads: bool = True) -> bool:
        """Run no more callbacks, and wait until those that run have returned.

        `wait_for_threads` False, or a call from one of those callbacks, waits for none.
        """
        ended = super().shutdown(timeout_sec)
        scheduler = self._run.scheduler
        thread = scheduler.current
        if wait_for_threads and thread is not None and thread not in self._pool:
            scheduler.wait_until(
                lambda: self._n_running == 0,
                reason="the end of the callbacks of a MultiThreadedExecutor",
            )
        return ended

    def _spin_once_impl(self, timeout_ns: int | None, future: Future | None) -> None:
        try:
            task = self._next_task(timeout_ns, future)
        except ExternalShutdownException:
            task = None
        if task is not None:
            # Begun by a thread of the pool, so that it is not found again.
            task._is_submitted = True
            self._submitted.append(task)
            self._futures.append(task)
            if self._n_running < self._n_threads:
                self._n_running += 1
                self._pool = [thread for thread in self._pool if not thread.finished]
                self._pool.append(
                    self._run.scheduler.spawn(
                        self._work, "executor thread", inherit=False, is_controllers=False
                    )
                )
        self._raise_what_failed()

    @property
    def _takes_work(self) -> bool:
        has_thread = self._n_running < self._n_threads or not self._submitted
        return super()._takes_work and has_thread

    def _has_work(self) -> bool:
        return any(task._exception is not None for task in self._futures) or super()._has_work()

    def _wait(self, timeout_ns: int | None, future: Future | None) -> bool:
        came = super()._wait(timeout_ns, future)
        self._raise_what_failed()
        return came

    def _raise_what_failed(self) -> None:
        for task in [each for each in self._futures if each._done]:
            self._futures.remove(task)
            task.result()

    def _work(self) -> None:
        try:
            while self._submitted:
                task = self._submitted.popleft()
                task._is_submitted = False
                # Who spins gets it from the task.
                with suppress(SystemExit, KeyboardInterrupt):
                    task()
        finally:
            self._n_running -= 1


def _what_is_waited_for(future: Future | None) -> tuple[WaitKind, str]:
    if future is None:
        return "idle", "callbacks"
    awaited = future._awaited
    return ("blocked", "a future") if awaited is None else ("unmet", awaited)


def _nanoseconds(seconds: float | None) -> int | None:
    return None if seconds is None or seconds < 0 else round(seconds * 1e9)


def _nothing() -> None:
    """Mark a timer as due; the executor that waits sees it."""


__all__ = _defined(globals())
