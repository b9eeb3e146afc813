"""Pools of processes, on the threads of an executor."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
from collections.abc import Callable, Iterator
from typing import Any


class _Result:
    """What a pool returns at once for work that is to be done."""

    def __init__(self, futures: list[concurrent.futures.Future[Any]], *, is_single: bool) -> None:
        self._futures = futures
        self._is_single = is_single

    def get(self, timeout: float | None = None) -> Any:
        """Wait for the result, at most `timeout` [s]."""
        self.wait(timeout)
        if not all(future.done() for future in self._futures):
            raise multiprocessing.TimeoutError
        results = [future.result() for future in self._futures]
        return results[0] if self._is_single else results

    def wait(self, timeout: float | None = None) -> None:
        """Wait until all is done, at most `timeout` [s]."""
        concurrent.futures.wait(self._futures, timeout)

    def ready(self) -> bool:
        """Return whether all is done."""
        return all(future.done() for future in self._futures)

    def successful(self) -> bool:
        """Return whether all was done without an exception."""
        if not self.ready():
            raise ValueError(f"{self!r} not ready")
        return all(future.exception() is None for future in self._futures)


class ProcessPool:
    """`multiprocessing.pool.Pool` on the threads of an executor."""

    def __init__(
        self,
        processes: int | None = None,
        initializer: Callable[..., object] | None = None,
        initargs: tuple[Any, ...] = (),
        maxtasksperchild: int | None = None,
    ) -> None:
        del maxtasksperchild
        self._executor = concurrent.futures.ThreadPoolExecutor(
            processes or os.cpu_count(), "PoolWorker", initializer, initargs
        )

    def apply(self, func: Callable[..., Any], args: Any = (), kwds: Any = None) -> Any:
        """Call a function in the pool, and wait for its result."""
        return self.apply_async(func, args, kwds).get()

    def apply_async(
        self,
        func: Callable[..., Any],
        args: Any = (),
        kwds: Any = None,
        callback: Callable[[Any], object] | None = None,
        error_callback: Callable[[BaseException], object] | None = None,
    ) -> _Result:
        """Call a function in the pool."""
        futures = [self._executor.submit(func, *args, **(kwds or {}))]
        return self._begin(_Result(futures, is_single=True), callback, error_callback)

    def map(self, func: Callable[..., Any], iterable: Any, chunksize: int | None = None) -> Any:
        """Call a function for each item, and wait for the list of results."""
        return self.map_async(func, iterable, chunksize).get()

    def map_async(
        self,
        func: Callable[..., Any],
        iterable: Any,
        chunksize: int | None = None,
        callback: Callable[[Any], object] | None = None,
        error_callback: Callable[[BaseException], object] | None = None,
    ) -> _Result:
        """Call a function for each item."""
        arguments = ((item,) for item in iterable)
        return self.starmap_async(func, arguments, chunksize, callback, error_callback)

    def starmap(self, func: Callable[..., Any], iterable: Any, chunksize: int | None = None) -> Any:
        """Call a function with each item as its arguments, and wait for the list of results."""
        return self.starmap_async(func, iterable, chunksize).get()

    def starmap_async(
        self,
        func: Callable[..., Any],
        iterable: Any,
        chunksize: int | None = None,
        callback: Callable[[Any], object] | None = None,
        error_callback: Callable[[BaseException], object] | None = None,
    ) -> _Result:
        """Call a function with each item as its arguments."""
        del chunksize
        futures = [self._executor.submit(func, *item) for item in iterable]
        return self._begin(_Result(futures, is_single=False), callback, error_callback)

    def imap(self, func: Callable[..., Any], iterable: Any, chunksize: int = 1) -> Iterator[Any]:
        """Yield the results for each item, in the order of the items."""
        del chunksize
        futures = [self._executor.submit(func, item) for item in iterable]
        return (future.result() for future in futures)

    def imap_unordered(
        self, func: Callable[..., Any], iterable: Any, chunksize: int = 1
    ) -> Iterator[Any]:
        """Yield the results for each item, as they come."""
        del chunksize
        futures = [self._executor.submit(func, item) for item in iterable]
        return (future.result() for future in concurrent.futures.as_completed(futures))

    def close(self) -> None:
        """Take no more work."""
        self._executor.shutdown(wait=False)

    def terminate(self) -> None:
        """Take no more work, and drop what has not begun."""
        self._executor.shutdown(wait=False, cancel_futures=True)

    def join(self) -> None:
        """Wait until the work is done."""
        self._executor.shutdown(wait=True)

    def _begin(
        self,
        result: _Result,
        callback: Callable[[Any], object] | None,
        error_callback: Callable[[BaseException], object] | None,
    ) -> _Result:
        if callback is not None or error_callback is not None:
            self._executor.submit(_call_back, result, callback, error_callback)
        return result

    def __enter__(self) -> ProcessPool:
        return self

    def __exit__(self, *error: object) -> None:
        self.terminate()


def _call_back(
    result: _Result,
    callback: Callable[[Any], object] | None,
    error_callback: Callable[[BaseException], object] | None,
) -> None:
    try:
        results = result.get()
    except Exception as error:  # noqa: BLE001 - whatever the work raised
        if error_callback is not None:
            error_callback(error)
        return
    if callback is not None:
        callback(results)


class ProcessPoolExecutor(concurrent.futures.ThreadPoolExecutor):
    """`concurrent.futures.ProcessPoolExecutor` on threads."""

    def __init__(
        self,
        max_workers: int | None = None,
        mp_context: object = None,
        initializer: Callable[..., object] | None = None,
        initargs: tuple[Any, ...] = (),
        *,
        max_tasks_per_child: int | None = None,
    ) -> None:
        del mp_context, max_tasks_per_child
        super().__init__(max_workers, "Process", initializer, initargs)
