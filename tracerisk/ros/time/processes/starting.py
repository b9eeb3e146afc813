"""The processes of `multiprocessing`, as threads: the simulated arm cannot be in two processes.

`multiprocessing.Process` keeps its own class. Only what starts it is replaced, and with it all
that processes share and wait for: locks, queues, pipes, pools, values. What is sent is copied by
pickle, as between processes. What stays different is memory: all see the same global variables.
"""

from __future__ import annotations

import concurrent.futures
import copy
import itertools
import multiprocessing
import multiprocessing.context
import multiprocessing.process
import os
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from typing import Any

from tracerisk.ros.controller.thread import RunOver
from tracerisk.ros.time.processes.pool import ProcessPool, ProcessPoolExecutor
from tracerisk.ros.time.processes.shared import Manager, ProcessQueue, array, pipe, value
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.threads import for_controller

_FIRST_PID = 100_000
"""What process identifiers are counted from: above those that Linux gives out by default."""
_NOTE = (
    "processes of multiprocessing run as threads of the controller's own process, as the simulated "
    "arm cannot be in two: what one assigns to a global variable, all see"
)
_START_METHODS = ("Process", "ForkProcess", "SpawnProcess", "ForkServerProcess")


def process_replacements(
    scheduler: Scheduler, note: Callable[[str], None]
) -> Iterator[tuple[Any, str, Any]]:
    """Yield owner, name and value of what the controller's processes are replaced by.

    `note` is called with what differs when the first of them starts.
    """
    shared = _Shared(scheduler, note)
    for name in _START_METHODS:
        kind = vars(multiprocessing.context).get(name)
        if kind is not None:
            real = vars(kind)["_Popen"].__func__
            yield kind, "_Popen", staticmethod(shared.start_instead_of(real))
    current = for_controller(scheduler, shared.current_process, multiprocessing.current_process)
    yield multiprocessing, "current_process", current
    yield multiprocessing.process, "current_process", current
    yield multiprocessing.context.BaseContext, "current_process", staticmethod(current)
    for name, make in shared.makers().items():
        context_method = vars(multiprocessing.context.BaseContext)[name]
        yield (
            multiprocessing.context.BaseContext,
            name,
            for_controller(scheduler, _without_self(make), context_method),
        )
        yield multiprocessing, name, for_controller(scheduler, make, vars(multiprocessing)[name])
    yield concurrent.futures, "ProcessPoolExecutor", ProcessPoolExecutor
    # Those of the controller end with the run: this process must not join them when it exits.
    yield multiprocessing.process, "_children", set()


def _without_self(make: Callable[..., Any]) -> Callable[..., Any]:
    return lambda _, *args, **kwargs: make(*args, **kwargs)


class _Shared:
    """What processes of one controller share."""

    def __init__(self, scheduler: Scheduler, note: Callable[[str], None]) -> None:
        self._scheduler = scheduler
        self._note = note
        self._pids = itertools.count(_FIRST_PID)
        self._by_thread: dict[int, multiprocessing.process.BaseProcess] = {}

    def start_instead_of(self, real: Callable[..., Any]) -> Callable[[Any], Any]:
        """Return what starts a process: a thread for the controller, else `real`."""

        def start(process: Any) -> Any:
            if self._scheduler.current is None:
                return real(process)
            pid = next(self._pids)
            if pid == _FIRST_PID:
                self._note(_NOTE)
            return _StartedProcess(self._scheduler, process, pid, self._by_thread)

        return start

    def current_process(self) -> multiprocessing.process.BaseProcess:
        """Return the process whose code runs; threads that it started count as the main one's."""
        base_process = self._by_thread.get(self._scheduler.baton.ident())
        if base_process is not None:
            return base_process
        main: multiprocessing.process.BaseProcess = vars(multiprocessing.process)[
            "_current_process"
        ]
        return main

    def makers(self) -> dict[str, Callable[..., Any]]:
        """Return what makes each shared object, by the names of `multiprocessing`."""
        return {
            "Lock": threading.Lock,
            "RLock": threading.RLock,
            "Condition": threading.Condition,
            "Semaphore": threading.Semaphore,
            "BoundedSemaphore": threading.BoundedSemaphore,
            "Event": threading.Event,
            "Barrier": threading.Barrier,
            "Queue": ProcessQueue,
            "JoinableQueue": ProcessQueue,
            "SimpleQueue": ProcessQueue,
            "Pipe": pipe,
            "Pool": ProcessPool,
            "Manager": Manager,
            "Value": value,
            "Array": array,
            "RawValue": lambda kind, *args: value(kind, *args, lock=False),
            "RawArray": lambda kind, size_or_values: array(kind, size_or_values, lock=False),
        }


class _StartedProcess:
    """A process that was started, as `multiprocessing` looks at it."""

    method = "thread"
    sentinel = -1
    """No file descriptor: only `join` waits for it."""

    def __init__(
        self,
        scheduler: Scheduler,
        process: Any,
        pid: int,
        by_thread: dict[int, multiprocessing.process.BaseProcess],
    ) -> None:
        self.pid = pid
        self.returncode: int | None = None
        self._scheduler = scheduler
        # As in another process its attributes are its own from here on.
        self._process = copy.copy(process)
        self._by_thread = by_thread
        self._thread = scheduler.spawn(self._run, process.name, daemon=process.daemon)

    def poll(self, flag: int = os.WNOHANG) -> int | None:
        """Return the exit code, `None` while it runs."""
        del flag
        if self.returncode is None:
            self._scheduler.touch()
        return self.returncode

    def wait(self, timeout: float | None = None) -> int | None:
        """Wait for the end, at most `timeout` [s], and return the exit code."""
        self._scheduler.wait_until(
            lambda: self._thread.finished,
            timeout_ns=None if timeout is None else round(timeout * 1e9),
            reason=f"the end of process {self._process.name}",
            on=self._thread,
        )
        return self.returncode

    def terminate(self) -> None:
        """End it at its next wait, as SIGTERM does at once."""
        self._end(-15)

    def kill(self) -> None:
        """End it at its next wait, as SIGKILL does at once."""
        self._end(-9)

    def close(self) -> None:
        """Forget it; nothing is open."""

    def _end(self, code: int) -> None:
        if self.returncode is None:
            self._thread.interrupt = _Ended(code)

    def _run(self) -> None:
        ident = self._scheduler.baton.ident()
        self._by_thread[ident] = self._process
        code = 1
        try:
            self._process.run()
            code = 0
        except RunOver:
            raise
        except _Ended as end:
            code = end.code
        except SystemExit as end:
            code = _exit_code(end)
        except BaseException as error:  # noqa: BLE001 - a process dies of it alone, and prints it
            self._scheduler.failed_threads.append((self._process.name, error))
            sys.stderr.write(f"Process {self._process.name}:\n{traceback.format_exc()}")
        finally:
            del self._by_thread[ident]
            self.returncode = code


class _Ended(BaseException):
    """Ends a process with the code of a signal."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


def _exit_code(end: SystemExit) -> int:
    if end.code is None:
        return 0
    if isinstance(end.code, int):
        return end.code
    sys.stderr.write(f"{end.code}\n")
    return 1
