"""Futures, and the tasks that an executor runs."""

from __future__ import annotations

import inspect
import sys
import warnings
from collections.abc import Callable, Generator
from contextlib import nullcontext
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import controller_frame
from tracerisk.ros.graph.failures import callback_failed
from tracerisk.ros.time.standstill import LONG_NS

from ._run import run


class Future:
    """What somebody will know later: a result, or an exception.

    `waits_for` says what completes it; who waits for what nothing provides is in a deadlock.
    `source` is the entity whose callback completes it.
    """

    def __init__(
        self, *, executor: Any = None, waits_for: str | None = None, source: Any = None
    ) -> None:
        self._done = False
        self._cancelled = False
        self._result: Any = None
        self._exception: BaseException | None = None
        self._callbacks: list[Callable[[Any], Any]] = []
        self._executor = executor
        self._waits_for = waits_for
        self._source = source
        self._left_ns: int | None = None

    def __await__(self) -> Generator[Any, None, Any]:
        while not self.is_over:
            asyncio = sys.modules.get("asyncio")
            if asyncio is None or asyncio._get_running_loop() is None:
                yield self
            else:
                # A task of asyncio comes back in the next round of its loop, which spins.
                run().scheduler.touch()
                yield
        return self.result()

    def cancel(self) -> None:
        """Ask for the end of what runs, if it is not done."""
        if not self._done:
            self._cancelled = True
        self._call_back()

    def cancelled(self) -> bool:
        """Return whether the future was cancelled."""
        return self._cancelled

    @property
    def is_over(self) -> bool:
        """Whether nobody waits for it any more; one that was cancelled may be awaited on."""
        return self._done or (
            self._cancelled and bool(run().runtime.distro.value("cancelled-future-is-over"))
        )

    def done(self) -> bool:
        """Return whether the future is complete."""
        if not self._done:
            self._end_if_left()
            # A loop that polls would else stop the time that it waits for.
            run().scheduler.touch()
        return self._done

    def _end_if_left(self) -> None:
        """End the run where a loop has long polled for what lies there and nothing spins."""
        scheduler = run().scheduler
        if self._source is None or not self._source._is_left_lying:
            self._left_ns = None
        elif self._left_ns is None:
            self._left_ns = scheduler.now_ns
        elif scheduler.now_ns - self._left_ns >= LONG_NS and scheduler.current is not None:
            frame = controller_frame()
            place = None if frame is None else Location(frame.f_code.co_filename, frame.f_lineno)
            scheduler.end(
                "deadlock",
                f"{scheduler.current.name} has asked for {LONG_NS / 1e9:g} s whether "
                f"{self._waits_for} is there: {self._source._node._meaning_of_wait().why}",
                place,
            )

    def result(self) -> Any:
        """Return the result, None where there is none yet.

        Raises:
            BaseException: what was set as the exception.
        """
        if self._exception is not None:
            raise self._exception
        return self._result

    def exception(self) -> BaseException | None:
        """Return the exception, if one was set."""
        return self._exception

    def set_result(self, result: Any) -> None:
        """Complete the future."""
        self._result = result
        self._done, self._cancelled = True, False
        self._call_back()

    def set_exception(self, exception: BaseException) -> None:
        """Complete the future with an exception, which `result` raises."""
        self._exception = exception
        self._done, self._cancelled = True, False
        self._call_back()

    def add_done_callback(self, callback: Callable[[Any], Any]) -> None:
        """Call `callback` with the future when it is complete: at once if it is."""
        if not self.is_over:
            self._callbacks.append(callback)
        elif self._executor is not None:
            _schedule(self._executor, callback, self)
        else:
            callback(self)

    def _set_executor(self, executor: Any) -> None:
        self._executor = executor

    def _call_back(self) -> None:
        callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            if self._executor is not None:
                _schedule(self._executor, callback, self)
                continue
            tracer = run().tracer
            root: Any = nullcontext() if tracer is None else tracer.root("done_callback")
            try:
                with root:
                    callback(self)
            except Exception as error:  # noqa: BLE001 - the controller's; the others still run
                callback_failed("a done callback", error)
                warnings.warn(f"Unhandled exception in done callback: {error}", stacklevel=2)

    @property
    def _awaited(self) -> str | None:
        """What completes the future, where somebody outside has to."""
        return self._waits_for


def _schedule(executor: Any, callback: Callable[[Any], Any], future: Future) -> None:
    # One that a program has written itself takes tasks, as the real library asks of it.
    create = getattr(executor, "_create_done_task", None) or executor.create_task
    create(callback, future)


class Task(Future):
    """A function or a coroutine that an executor runs, step by step.

    `stack` is the context manager within which each step runs: it is a root of its own, or goes
    on with the stack of who created the task. `_entity` is that whose callback it runs and
    `_node` the entity's node, None for other tasks.
    """

    def __init__(
        self,
        handler: Any,
        args: Any = None,
        kwargs: Any = None,
        executor: Any = None,
        *,
        stack: Any = None,
    ) -> None:
        super().__init__(executor=executor)
        self._args = tuple(args or ())
        self._kwargs = dict(kwargs or {})
        self._handler = handler
        self._stack = nullcontext() if stack is None else stack
        self._executing = False
        self._is_submitted = False
        self._waits_on: Any = None
        self._entity: Any = None
        self._node: Any = None
        if inspect.iscoroutinefunction(handler):
            with self._stack:
                self._handler = handler(*self._args, **self._kwargs)

    def __call__(self) -> None:
        """Run the function, or the coroutine until it waits."""
        if self._done or self._executing:
            return
        self._executing = True
        try:
            with self._stack:
                if inspect.iscoroutine(self._handler):
                    self._waits_on = self._handler.send(None)
                    return
                result = self._handler(*self._args, **self._kwargs)
        except StopIteration as stop:
            self._complete(stop.value, None)
        except Exception as error:  # noqa: BLE001 - kept for who asks for the result
            self._complete(None, error)
        except (SystemExit, KeyboardInterrupt) as error:
            self._complete(None, error)
            raise
        else:
            self._complete(result, None)
        finally:
            self._executing = False

    def executing(self) -> bool:
        """Return whether a step runs."""
        return self._executing

    def cancel(self) -> None:
        """Run no further step."""
        if not self._done and inspect.iscoroutine(self._handler) and not self._executing:
            self._handler.close()
        super().cancel()

    @property
    def is_ready(self) -> bool:
        """Whether a step can run: nothing that the task waits for is still to come."""
        if self._done or self._executing or self._is_submitted or self._cancelled:
            return False
        waits_on = self._waits_on
        return waits_on.is_over if isinstance(waits_on, Future) else True

    def _complete(self, result: Any, error: BaseException | None) -> None:
        self._handler = None
        if error is not None:
            self.set_exception(error)
        else:
            self.set_result(result)

    @property
    def _awaited(self) -> str | None:
        return self._waits_on._awaited if isinstance(self._waits_on, Future) else None
