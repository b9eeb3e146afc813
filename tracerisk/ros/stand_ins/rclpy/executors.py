"""Executors: what runs the callbacks of nodes, and in which thread."""

from __future__ import annotations

import inspect
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.controller.thread import ControllerThread, spinning
from tracerisk.ros.imports.exported import defined as _defined

from ._executor_work import WorkFinding
from ._handle import OF_CONTEXT, check_context
from ._rclpy_pybind11 import RCLError
from ._run import run
from .context import Context, check_with_block
from .task import Future, Task

_NO_TIMER = "failed to create timer"
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


class Executor(WorkFinding):
    """Base of the executors; one of its own has to define `_spin_once_impl`."""

    def __init__(self, *, context: Context | None = None) -> None:
        self._run = run()
        self._context = self._run.default_context if context is None else context
        # As in the real library: Python's own error where the context has never begun.
        handle: Any = self._context.handle
        with handle:
            check_context(self._context, "failed to create guard_condition", OF_CONTEXT)
        self._nodes: list[Any] = []
        self._tasks: list[Task] = []
        self._batch: deque[Any] = deque()
        self._has_looked_at_tasks = False
        self._n_working = 0
        self._waits: list[tuple[Any, ...]] = []
        self._is_shutdown = False
        self._is_spinning = False
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
        self._trigger()
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
        """Run no more callbacks.

        Whether it waits `timeout_sec` seconds, or for ever, until those that run have returned
        depends on the distribution; False where they have not.
        """
        self._is_shutdown = True
        if self._n_working and not self._has_ended(timeout_sec):
            return False
        self._nodes.clear()
        self._batch.clear()
        return True

    def _has_ended(self, timeout_sec: float | None) -> bool:
        """Return whether the callbacks that run have returned, or nobody asks."""
        distro = self._run.runtime.distro
        distro.decided("executor-shutdown-waits", asking_place())
        if not distro.value("executor-shutdown-waits"):
            return True
        return self._run.scheduler.wait_until(
            lambda: self._n_working == 0,
            timeout_ns=_nanoseconds(timeout_sec),
            reason="the end of the callbacks of an executor, of which this may be one",
        )

    def _trigger(self) -> None:
        """Wake who waits; that of an executor which was shut down is gone.

        Raises:
            AttributeError: the executor was shut down.
        """
        if self._is_shutdown:
            raise AttributeError("'NoneType' object has no attribute 'trigger'")

    def add_node(self, node: Any) -> bool:
        """Run the callbacks of a node too; False where the executor does already."""
        if node in self._nodes:
            return False
        self._nodes.append(node)
        node.executor = self
        self._trigger()
        return True

    def remove_node(self, node: Any) -> None:
        """Run the callbacks of a node no longer."""
        if self._leave(node):
            self._trigger()

    def _leave(self, node: Any) -> bool:
        """Take a node out, also after the shutdown; return whether it was in."""
        if node not in self._nodes:
            return False
        self._nodes.remove(node)
        return True

    def wake(self) -> None:
        """Look for work again; the executor sees for itself what is new."""

    def get_nodes(self) -> list[Any]:
        """Return the nodes."""
        return list(self._nodes)

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down."""
        scheduler = self._run.scheduler
        self._is_spinning = True
        try:
            with spinning(scheduler.current, scheduler.now_ns), self._spun():
                while self._context.is_valid and not self._is_shutdown:
                    self.spin_once()
        finally:
            self._is_spinning = False

    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        """Run callbacks until a future is complete, or for `timeout_sec` seconds."""
        future.add_done_callback(self._wake_for)
        with self._spun():
            if timeout_sec is None or timeout_sec < 0:
                while self._goes_on(future):
                    self._turn(None, future)
                return
            scheduler = self._run.scheduler
            end_ns = scheduler.now_ns + round(timeout_sec * 1e9)
            while self._goes_on(future):
                self._turn(max(0, end_ns - scheduler.now_ns), future)
                if scheduler.now_ns >= end_ns:
                    return

    def _turn(self, timeout_ns: int | None, future: Future) -> None:
        """Run one callback of those that a future may need; each time asks to be woken by it."""
        if self._adds_wakes:
            future.add_done_callback(self._wake_for)
        self._spin_once_impl(timeout_ns, future)

    def _wake_for(self, future: Future) -> None:
        """Be woken by a future: a task like any other, which takes its turn but no time."""
        self._run.scheduler.note_progress()
        self.wake()

    @property
    def _adds_wakes(self) -> bool:
        return True

    def _goes_on(self, future: Future) -> bool:
        return self._context.is_valid and not future.is_over and not self._is_shutdown

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
            self._turn(_nanoseconds(seconds), future)

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
        return any(spinner is not thread for spinner in self._spinners)

    @property
    def _takes_work(self) -> bool:
        """Whether a callback that becomes ready is run, or has to wait until others return."""
        return self._n_waiting > 0

    # Finding work

    def _next_task(self, timeout_ns: int | None, future: Future | None) -> Task | None:
        """Wait for work and return it; None after the timeout, or where there is to be none.

        Raises:
            ExternalShutdownException: the context was shut down meanwhile.
            RCLError: it was before.
            ValueError: another thread waits here for the same.
        """
        scheduler = self._run.scheduler
        scheduler.count_call()
        deadline_ns = None if timeout_ns is None else scheduler.now_ns + timeout_ns
        while True:
            if self._is_shutdown or (future is not None and future.is_over):
                return None
            task = self._from_batch()
            if task is not None:
                return task
            doing = "failed to initialize wait set" if timeout_ns is None else _NO_TIMER
            check_context(self._context, doing, OF_CONTEXT)
            self._batch.extend(self._ready())
            if self._batch:
                continue
            left_ns = None if deadline_ns is None else max(0, deadline_ns - scheduler.now_ns)
            # All that wait with the same arguments share one generator in the real library.
            arguments = (timeout_ns, future)
            if arguments in self._waits:
                raise ValueError("generator already executing")
            self._waits.append(arguments)
            try:
                came = self._wait(left_ns, future)
            finally:
                self._waits.remove(arguments)
            if not came:
                return None
            if not self._is_shutdown and not self._context.is_valid:
                raise ExternalShutdownException

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

    def __enter__(self) -> Executor:
        check_with_block()
        return self

    def __exit__(self, *error: object) -> None:
        self.shutdown()


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins."""

    @property
    def _adds_wakes(self) -> bool:
        return bool(self._run.runtime.distro.value("each-turn-adds-a-done-callback"))

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
        if num_threads is not None and num_threads <= 0:
            raise ValueError("max_workers must be greater than 0")
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
        self._begun: Task | None = None
        self._has_failed_at_once = False
        self._lacks_subscription = False
        self._pool: list[ControllerThread] = []

    def _spin_once_impl(self, timeout_ns: int | None, future: Future | None) -> None:
        try:
            task = self._next_task(timeout_ns, future)
        except ExternalShutdownException:
            task = None
        self._check_indices(task)
        if task is not None:
            # Begun by a thread of the pool, so that it is not found again.
            task._is_submitted = True
            self._submitted.append(task)
            self._futures.append(task)
            self._begun = task
            if self._n_running < self._n_threads:
                self._n_running += 1
                self._pool = [thread for thread in self._pool if not thread.finished]
                self._pool.append(
                    self._run.scheduler.spawn(
                        self._work, "executor thread", inherit=False, is_controllers=False
                    )
                )
            self._raise_what_failed()

    def _check_indices(self, task: Task | None) -> None:
        """Fail as the real library does where two threads wait for a node with an action client.

        While a thread of the pool has a subscription, the others wait without it. The client keeps
        where it stands in what was waited for last, which is too far in what a thread waits for
        that began without the subscription.

        Raises:
            RCLError: this thread was the first to spin, and another one waits here, too.
        """
        is_first = self._spinners[:1] == [self._run.scheduler.current]
        if self._lacks_subscription and is_first:
            self._lacks_subscription = False
            raise RCLError(
                "Failed to get number of ready entities for action client: wait set index for "
                "status subscription is out of bounds"
            )
        node = None if task is None else task._node
        if node is None or task is None or len(set(self._spinners)) < 2:
            return
        if task._entity in node._subscriptions:
            waitables = (waitable for node in self._nodes for waitable in node._waitables)
            self._lacks_subscription = any(hasattr(one, "send_goal_async") for one in waitables)

    @property
    def _takes_work(self) -> bool:
        has_thread = self._n_running < self._n_threads or not self._submitted
        return super()._takes_work and has_thread

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback as far as it goes at once; what fails later waits for other work."""
        before = self._begun
        super().spin_once(timeout_sec)
        if self._begun is not before and not self._is_spinning:
            self._run.scheduler.give_way()
            self._raise_what_failed()

    def _has_work(self) -> bool:
        return self._has_failed_at_once or super()._has_work()

    def _wait(self, timeout_ns: int | None, future: Future | None) -> bool:
        came = super()._wait(timeout_ns, future)
        if self._has_failed_at_once:
            self._raise_what_failed()
        return came

    def _raise_what_failed(self) -> None:
        self._has_failed_at_once = False
        for task in [future for future in self._futures if future._done]:
            self._futures.remove(task)
            task.result()

    def _work(self) -> None:
        try:
            while self._submitted:
                task = self._submitted.popleft()
                task._is_submitted = False
                # Who spins gets it from the task.
                began_ns = self._run.scheduler.now_ns
                with suppress(SystemExit, KeyboardInterrupt):
                    task()
                failed = task._done and task._exception is not None
                if failed and self._run.scheduler.now_ns == began_ns:
                    self._has_failed_at_once = True
        finally:
            self._n_running -= 1


def _nanoseconds(seconds: float | None) -> int | None:
    return None if seconds is None or seconds < 0 else round(seconds * 1e9)


__all__ = _defined(globals())
