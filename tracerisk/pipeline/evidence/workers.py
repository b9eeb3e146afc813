"""Jobs that any executor can do: local processes by default, and a pool that outlives a worker."""

from __future__ import annotations

import atexit
import contextlib
import multiprocessing
import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TypeVar

from tracerisk.common.campaign import CampaignOptions
from tracerisk.common.sandbox.fork_server import several_come
from tracerisk.errors import ControllerFailedError

J = TypeVar("J")
R = TypeVar("R")

CellProgress = Callable[[int, int, float], None]
"""Called with how many are done, of how many, and the seconds left."""

# Forked processes would share the threads and files of this one.
_CONTEXT = multiprocessing.get_context("spawn")
_POOLS = 3
"""How often a pool of workers of which one died is started again."""
_ENDING = threading.Event()
"""Set in a worker that ends, before its temporary files go."""


@dataclass(frozen=True, slots=True)
class Workers:
    """Who does jobs."""

    jobs: int | None = None
    """How many local processes work at a time; `None` for one a core."""
    executor: Executor | None = None
    """Whose workers do the jobs in place of local processes."""
    most_s: float | None = None
    """After how long no further job begins, [s] of wall time, and local processes end in the middle
    of theirs; the workers of an executor end those that they have begun."""
    folder: Path | None = None
    """A folder for temporary files of local processes.

    Whoever gives it removes it: they end in the middle of what they do.
    """
    ending_s: float = 10.0
    """After how long a local process that does not end is killed, [s] of wall time."""

    @classmethod
    def of(cls, options: CampaignOptions, folder: Path | None = None) -> Workers:
        """Return the workers of a campaign."""
        return cls(options.jobs, options.executor, options.most_s, folder)

    def run(
        self, function: Callable[[J], R], todo: Sequence[J], progress: CellProgress | None = None
    ) -> Iterator[tuple[J, R]]:
        """Yield each job with its result as it is done; the order depends on the workers.

        What a job raises is raised. Raises ControllerFailedError where workers die again and
        again.
        """
        began = time.monotonic()
        left, done = list(todo), 0
        for attempt in range(_POOLS):
            workers = min(self.jobs or os.cpu_count() or 1, max(1, len(left)))
            alive, end = _CONTEXT.Pipe(duplex=False)
            before = set(multiprocessing.active_children())
            pool = self.executor or _pool(workers, alive, self.folder)
            pending: dict[Future[R], J] = {}
            try:
                while left or pending:
                    left_s = None if self.most_s is None else self.most_s + began - time.monotonic()
                    if left_s is not None and left_s <= 0.0:
                        left.clear()
                        is_kept = Future.done if self.executor is None else _has_begun
                        pending = {
                            future: job for future, job in pending.items() if is_kept(future)
                        }
                    while left and len(pending) < 2 * workers:
                        pending[pool.submit(function, left[0])] = left[0]
                        left.pop(0)
                    if not pending:
                        return
                    limit_s = None if self.executor is not None else left_s
                    for future in wait(pending, limit_s, return_when=FIRST_COMPLETED).done:
                        result = future.result()
                        done += 1
                        yield pending.pop(future), result
                        if progress is not None:
                            seconds = time.monotonic() - began
                            progress(done, len(todo), seconds / done * (len(todo) - done))
                return
            except BrokenProcessPool:
                left = [*pending.values(), *left]
                if self.executor is not None or attempt == _POOLS - 1:
                    raise ControllerFailedError(
                        f"a worker died {_POOLS} times, for want of memory maybe; what was done is "
                        "kept: run the same command again with fewer workers (-j 1)"
                    ) from None
            finally:
                started = set(multiprocessing.active_children()) - before
                if self.executor is None:
                    pool.shutdown(wait=False, cancel_futures=True)
                # Whoever interrupts this waits for no job: workers end in the middle of theirs.
                end.close()
                alive.close()
                if self.executor is None:
                    for base_process in started:
                        base_process.join(self.ending_s)
                        if base_process.exitcode is None:
                            base_process.kill()


def _has_begun(future: Future[R]) -> bool:
    """Return whether a job has begun; one that has not is taken back."""
    return not future.cancel()


def _pool(workers: int, alive: Connection, folder: Path | None) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(
        workers, mp_context=_CONTEXT, initializer=_begin, initargs=(alive, folder)
    )


def is_ending() -> bool:
    """Return whether this process is a worker that ends, or whose campaign was killed.

    What it has read since may be gone in part: whoever ends or comes next removes the files.
    """
    parent = multiprocessing.parent_process()
    return _ENDING.is_set() or (parent is not None and not parent.is_alive())


def _begin(alive: Connection, folder: Path | None) -> None:
    """Begin a worker: its temporary files go into the folder, and it ends with its parent.

    It ends where its parent closes the other end, or ends, however that does.
    """
    if folder is not None:
        os.environ["TMPDIR"] = tempfile.tempdir = tempfile.mkdtemp(prefix="worker-", dir=folder)

    def watch() -> None:
        with contextlib.suppress(OSError, EOFError):
            alive.recv_bytes()
        _ENDING.set()
        # The folders that this process was to remove at its end.
        atexit._run_exitfuncs()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    several_come()
