"""Put virtual time in the place of the machine's, for the threads of the controller alone."""

from __future__ import annotations

import atexit
import concurrent.futures
import concurrent.futures.thread as pool
import datetime as dt
import errno
import functools
import itertools
import os
import queue
import select
import selectors
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.machinery import ExtensionFileLoader
from sys import _getframe
from typing import Any

from tracerisk.common.replaced_names import replaced
from tracerisk.ros.controller.frames import is_quiet
from tracerisk.ros.controller.thread import RunOver
from tracerisk.ros.time.alarm import VirtualAlarm
from tracerisk.ros.time.clock import VirtualClock
from tracerisk.ros.time.processes.programs import program_replacements
from tracerisk.ros.time.processes.sockets import socket_replacements
from tracerisk.ros.time.processes.starting import process_replacements
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.seeded_randomness import entropy_replacements, seeded_generators
from tracerisk.ros.time.selector import VirtualSelector, select_replacements
from tracerisk.ros.time.threads import Lock, ThreadHandle, ThreadStarter, for_controller

_HANDLED = frozenset({signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2})
"""The signals that a controller may send itself and handle."""
_real_selector = selectors.DefaultSelector
# The one in C waits on a lock of its own.
_SimpleQueue: Any = vars(queue)["_PySimpleQueue"]


@contextmanager
def virtual_time(
    scheduler: Scheduler, *, seed: int = 0, note: Callable[[str], None] = lambda _: None
) -> Iterator[None]:
    """Replace clocks, sleeps, locks, threads, processes and entropy; undo it all at the end.

    What is random is drawn from `seed`. `note` is called with what differs where the
    controller starts processes, which run as threads.
    Threads that are not under `scheduler` go on with the real ones. Names that a module took
    from another before (`from time import sleep`) are not reached, so a controller must be
    imported inside.
    """
    scheduler.exit_calls.at_main_end(lambda: _stop_pools(scheduler))
    replacements = (
        *scheduler.baton.replacements(),
        *_replacements(scheduler),
        *process_replacements(scheduler, note),
    )
    with (
        replaced(replacements),
        seeded_generators(seed),
        replaced(entropy_replacements(scheduler, seed)),
    ):
        yield


def _replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    clock = VirtualClock(scheduler)
    yield from _loader_replacements()
    for name, function in clock.time_functions().items():
        yield time, name, function
    for name, replacement in clock.date_classes().items():
        yield dt, name, replacement
    yield select, "select", clock.select
    yield from _thread_replacements(scheduler)
    yield from _poll_replacements(scheduler)
    yield from _pool_replacements(scheduler)
    yield from _process_replacements(scheduler)
    yield from socket_replacements(scheduler)
    yield from program_replacements(scheduler)


def _loader_replacements() -> Iterator[tuple[Any, str, Any]]:
    """Yield loaders that show compiled modules the classes in C: they rely on their layout."""
    real = {"date": dt.date, "datetime": dt.datetime}

    def with_real(load: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(load)
        def loaded(*given: Any) -> Any:
            shown = {name: vars(dt)[name] for name in real}
            vars(dt).update(real)
            try:
                return load(*given)
            finally:
                vars(dt).update(shown)

        return loaded

    for name in ("create_module", "exec_module"):
        yield ExtensionFileLoader, name, with_real(vars(ExtensionFileLoader)[name])


def _thread_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    starter = ThreadStarter(scheduler)
    # The Python class is written on `_allocate_lock` and so waits in virtual time.
    reentrant = for_controller(scheduler, vars(threading)["_PyRLock"], threading.RLock)
    low_level = sys.modules["_thread"]
    for owner, name, value in (
        (low_level, "allocate_lock", starter.allocate_lock),
        (low_level, "allocate", starter.allocate_lock),
        (low_level, "start_new_thread", starter.start_new_thread),
        (low_level, "start_new", starter.start_new_thread),
        (low_level, "RLock", reentrant),
        (threading, "_allocate_lock", starter.allocate_lock),
        (threading, "Lock", starter.allocate_lock),
        (threading, "RLock", reentrant),
        (threading, "_time", lambda: scheduler.now_ns / 1e9),
        (threading, "_counter", itertools.count(1).__next__),
        (functools, "RLock", reentrant),
        (queue, "time", lambda: scheduler.now_ns / 1e9),
        (queue, "SimpleQueue", _SimpleQueue),
    ):
        if name in vars(owner):
            is_clock = name in ("_time", "time")
            real = vars(owner)[name]
            yield owner, name, for_controller(scheduler, value, real) if is_clock else value
    known = vars(threading)
    if "_start_joinable_thread" in known:
        real_start, real_handle = known["_start_joinable_thread"], known["_ThreadHandle"]

        def start_joinable(
            function: Callable[[], object], handle: Any = None, daemon: bool = True
        ) -> Any:
            return starter.start_joinable_thread(real_start, function, handle, daemon)

        make_handle = for_controller(scheduler, lambda: ThreadHandle(scheduler), real_handle)
        yield threading, "_start_joinable_thread", start_joinable
        yield threading, "_ThreadHandle", make_handle
    else:
        real_sentinel = known["_set_sentinel"]
        yield threading, "_start_new_thread", starter.start_new_thread
        yield threading, "_set_sentinel", lambda: starter.set_sentinel(real_sentinel)
    yield threading, "_make_invoke_excepthook", _quiet_excepthook(scheduler)


def _quiet_excepthook(scheduler: Scheduler) -> Callable[[], Callable[[threading.Thread], None]]:
    real_make = vars(threading)["_make_invoke_excepthook"]

    def make() -> Callable[[threading.Thread], None]:
        real = real_make()

        def invoke(thread: threading.Thread) -> None:
            error = sys.exc_info()[1]
            if isinstance(error, RunOver):
                return
            if error is not None and scheduler.current is not None:
                scheduler.failed_threads.append((thread.name, error))
            real(thread)

        return invoke

    return make


def _poll_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    """A loop that asks one of these again and again is a busy wait: each no moves the clock."""
    polls: tuple[tuple[type, str, Callable[[Any], bool]], ...] = (
        (threading.Event, "is_set", lambda found: not found),
        (threading.Thread, "is_alive", bool),
        (threading.Semaphore, "acquire", lambda found: not found),
        (queue.Queue, "empty", bool),
        (queue.Queue, "qsize", lambda found: found == 0),
        (_SimpleQueue, "empty", bool),
        (_SimpleQueue, "qsize", lambda found: found == 0),
        (concurrent.futures.Future, "done", lambda found: not found),
        (concurrent.futures.Future, "running", bool),
    )
    for owner, name, waits in polls:
        yield owner, name, _poll(scheduler, vars(owner)[name], waits)
    for kind in (queue.Queue, _SimpleQueue):
        yield kind, "get", _poll_get(scheduler, kind.get)


def _poll_get(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(real)
    def get(self: Any, block: bool = True, timeout: float | None = None) -> Any:
        try:
            return real(self, block, timeout)
        except queue.Empty:
            if not block:
                scheduler.touch()
            raise

    return get


def _poll(
    scheduler: Scheduler, real: Callable[..., Any], waits: Callable[[Any], bool]
) -> Callable[..., Any]:
    @functools.wraps(real)
    def ask(*args: Any, **kwargs: Any) -> Any:
        poll = real(*args, **kwargs)
        if waits(poll) and not is_quiet(_getframe(1)):
            scheduler.touch()
        return poll

    return ask


def _pool_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    # Held while a worker thread starts: a real lock would stop the next thread for good.
    real_lock = vars(pool)["_global_shutdown_lock"]
    yield pool, "_global_shutdown_lock", _LockOfEither(scheduler, real_lock)
    yield pool, "_shutdown", vars(pool)["_shutdown"]
    real_submit: Callable[..., Any] = pool.ThreadPoolExecutor.submit
    tracer = scheduler.tracer

    @functools.wraps(real_submit)
    def submit(self: Any, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        if tracer is None or scheduler.current is None:
            return real_submit(self, fn, *args, **kwargs)
        captured = tracer.capture()

        @functools.wraps(fn)
        def run(*args: Any, **kwargs: Any) -> Any:
            with tracer.resume(captured):
                return fn(*args, **kwargs)

        return real_submit(self, run, *args, **kwargs)

    yield pool.ThreadPoolExecutor, "submit", submit
    real_add = concurrent.futures.Future.add_done_callback

    @functools.wraps(real_add)
    def add_done_callback(self: Any, fn: Callable[[Any], object]) -> None:
        if tracer is None or scheduler.current is None:
            real_add(self, fn)
            return

        @functools.wraps(fn)
        def call(future: Any) -> None:
            with tracer.root("done_callback"):
                fn(future)

        real_add(self, call)

    yield concurrent.futures.Future, "add_done_callback", add_done_callback


def _stop_pools(scheduler: Scheduler) -> None:
    """End the workers of thread pools when they have done what was submitted, as at exit."""
    vars(pool)["_shutdown"] = True
    mine = {thread.ident for thread in scheduler.threads}
    for thread, work in list(vars(pool)["_threads_queues"].items()):
        if thread.ident in mine:
            work.put(None)


class _LockOfEither:
    """A lock that is virtual for the controller's threads and the real one for others."""

    def __init__(self, scheduler: Scheduler, real: Any) -> None:
        self._scheduler = scheduler
        self._real = real
        self._virtual = Lock(scheduler)

    def __enter__(self) -> Any:
        return self._lock.__enter__()

    def __exit__(self, *args: Any) -> None:
        self._lock.__exit__(*args)

    @property
    def _lock(self) -> Any:
        return self._virtual if self._scheduler.current is not None else self._real


def _no_fork(scheduler: Scheduler, name: str, real: Callable[[], Any]) -> Callable[[], Any]:
    @functools.wraps(real)
    def fork() -> Any:
        if scheduler.current is None:
            return real()
        raise RuntimeError(
            f"os.{name}: a traced controller runs in one process, and its simulated arm cannot be "
            "in two; use threads, or multiprocessing, whose processes run as threads"
        )

    return fork


def _signal_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    """Yield what sends the controller's own process a signal, and what handles it."""
    signals, low_level = scheduler.signals, sys.modules["_thread"]
    real_kill, own = os.kill, os.getpid()

    def set_handler(number: int, handler: Any, /) -> Any:
        main = scheduler.current is not None and scheduler.current.is_main
        if scheduler.process is None and not main:
            raise ValueError("signal only works in main thread of the main interpreter")
        if not callable(handler) and handler not in (signal.SIG_DFL, signal.SIG_IGN):
            raise TypeError(
                "signal handler must be signal.SIG_IGN, signal.SIG_DFL, or a callable object"
            )
        if number in (signal.SIGKILL, signal.SIGSTOP):
            raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))
        if number not in signal.valid_signals():
            raise ValueError("signal number out of range")
        return signals.set_handler(int(number), handler)

    def kill(process: int, number: int, /) -> None:
        is_own = process == own and scheduler.process is None and number in _HANDLED
        if not is_own or not scheduler.send_signal(int(number)):
            real_kill(process, number)

    def raise_signal(number: int, /) -> None:
        kill(own, number)

    def interrupt_main(number: int = signal.SIGINT, /) -> None:
        scheduler.send_signal(int(number), from_python=True)

    for owner, name, value in (
        (signal, "signal", set_handler),
        (signal, "getsignal", lambda number: signals.handler(int(number))),
        (signal, "raise_signal", raise_signal),
        (os, "kill", kill),
        (low_level, "interrupt_main", interrupt_main),
    ):
        yield owner, name, for_controller(scheduler, value, vars(owner)[name])


def _process_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    real_register, real_unregister = atexit.register, atexit.unregister

    def register(function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        if scheduler.current is None:
            return real_register(function, *args, **kwargs)
        scheduler.exit_calls.at_exit(functools.partial(function, *args, **kwargs), function)
        return function

    def unregister(function: Callable[..., Any], /) -> None:
        scheduler.exit_calls.forget(function)
        real_unregister(function)

    def pause() -> None:
        scheduler.wait_until(lambda: False, reason="a signal", kind="idle")

    yield from _signal_replacements(scheduler)
    for name in ("fork", "forkpty"):
        yield os, name, _no_fork(scheduler, name, vars(os)[name])
    yield atexit, "register", register
    yield atexit, "unregister", unregister
    yield signal, "pause", for_controller(scheduler, pause, signal.pause)
    for name, function in VirtualAlarm(scheduler).functions().items():
        yield signal, name, function
    selector = for_controller(scheduler, lambda: VirtualSelector(scheduler), _real_selector)
    yield selectors, "DefaultSelector", selector
    yield from select_replacements(scheduler)
