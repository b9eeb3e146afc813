"""The controller's threads as greenlets of one real thread, so that the process can be forked.

What Python keeps for each thread is exchanged with the baton: what `threading.local` and C modules
keep in the dictionary of the thread's state, the running event loop of asyncio, the functions that
trace and profile, and the hooks of asynchronous generators. The context of context variables, the
stack and the exception that is handled are greenlets' own.

From Python 3.13 on a `threading.local` is no part of that dictionary: those that are made during
the run go by `threading.current_thread`, and of those before it only that of asyncio is exchanged.
"""

from __future__ import annotations

import _threading_local
import ctypes
import signal
import sys
import threading
from _thread import get_ident
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NoReturn

from tracerisk.common import dependencies
from tracerisk.ros.controller.thread import ControllerThread

_LOCALS_ARE_KEPT = sys.version_info < (3, 13)
"""Whether a `threading.local` keeps what is a thread's own in the dictionary of its state."""
_ONLY_MAIN = "signal only works in main thread of the main interpreter"


@dataclass(slots=True)
class _ThreadState:
    """What Python keeps for a thread, stored while another has the baton."""

    kept: dict[Any, Any] = field(default_factory=dict)
    """The dictionary of the thread's state, which holds its `threading.local` values."""
    of_asyncio: dict[str, Any] = field(default_factory=dict)
    """The `threading.local` of asyncio's event loop policy, from Python 3.13 on."""
    loop: Any = None
    """The running event loop; `None` where none runs."""
    task: Any = None
    """The current task of that loop; `None` outside one."""
    tracing: Any = None
    """The function set by `sys.settrace`."""
    profiling: Any = None
    """The function set by `sys.setprofile`."""
    hooks: tuple[Any, Any] = (None, None)
    """The hooks of asynchronous generators: first iteration and finalizer."""


class GreenletBaton:
    """Greenlets, of which the one runs that was switched to.

    Raises DependencyError where the package greenlet is not installed.
    """

    def __init__(self) -> None:
        dependencies.check(("greenlet",))
        import greenlet

        self._greenlet: Any = greenlet.greenlet
        self._main: Any = greenlet.getcurrent()
        self._real = get_ident()
        self._running = self._real
        self._next_ident = 1
        self._state = _dictionary_of_thread()
        # One that is collected would get an exception that its code may swallow.
        self._for_good: list[Any] = []

    def ident(self) -> int:
        """Return the identifier of the greenlet that runs, or of a thread that is no greenlet's."""
        real = get_ident()
        return self._running if real == self._real else real

    def take(self, thread: ControllerThread) -> int:
        """Give the calling thread the baton; its identifier stays its own."""
        if get_ident() != self._real:
            raise RuntimeError("greenlets run in the thread that has made their baton")
        thread.gate = self._main
        return self._real

    def start(self, thread: ControllerThread, run: Callable[[], None]) -> int:
        """Make a greenlet; its identifier is that of no real thread."""

        def begin(*_: object) -> None:
            self._enter(ident, _ThreadState())
            run()

        ident, self._next_ident = self._next_ident, self._next_ident + 1
        # The parent by default, which started it, would close a circle in `leave`.
        thread.gate = self._greenlet(begin, self._main)
        return ident

    def hand(self, thread: ControllerThread, following: ControllerThread) -> None:  # noqa: ARG002
        """Switch to the other greenlet."""
        ident, state = self._running, self._left()
        following.gate.switch()
        self._enter(ident, state)

    def hand_for_good(self, thread: ControllerThread, following: ControllerThread) -> NoReturn:
        """Switch to the other greenlet; this one is kept until the process ends."""
        self._for_good.append(thread.gate)
        while True:
            self.hand(thread, following)

    def leave(self, thread: ControllerThread, following: ControllerThread) -> None:
        """Switch to the other greenlet when this one, which is about to, has ended."""
        self._left()
        thread.gate.parent = following.gate

    def replacements(self) -> Iterator[tuple[Any, str, Any]]:
        """Yield what identifies threads: their identifiers, and what only the main one may do."""
        for owner, name in (
            (sys.modules["_thread"], "get_ident"),
            (threading, "get_ident"),
            (threading, "_get_ident"),
        ):
            if name in vars(owner):
                yield owner, name, self.ident
        if not _LOCALS_ARE_KEPT:
            yield sys.modules["_thread"], "_local", _threading_local.local
            yield threading, "local", _threading_local.local
        yield signal, "set_wakeup_fd", self._only_in_main(signal.set_wakeup_fd)
        if "pthread_kill" in vars(signal):
            yield signal, "pthread_kill", self._to_real(signal.pthread_kill)

    def _only_in_main(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **kwargs: Any) -> Any:
            if self.ident() != get_ident():
                raise ValueError(_ONLY_MAIN)
            return real(*args, **kwargs)

        return call

    def _to_real(self, real: Callable[[int, int], None]) -> Callable[[int, int], None]:
        # The C library believes in any number that it is given.
        def call(ident: int, number: int) -> None:
            real(self._real if 0 < ident < self._next_ident else ident, number)

        return call

    def _left(self) -> _ThreadState:
        """Take off what Python keeps for the thread that runs, and return it."""
        loop, task = _asyncio_left()
        first, last = sys.get_asyncgen_hooks()
        state = _ThreadState(
            dict(self._state), _taken(), loop, task, sys.gettrace(), sys.getprofile(), (first, last)
        )
        self._state.clear()
        return state

    def _enter(self, ident: int, state: _ThreadState) -> None:
        """Put on what Python keeps for the thread that runs now."""
        self._running = ident
        self._state.clear()
        self._state.update(state.kept)
        if state.of_asyncio:
            _local_of_asyncio().update(state.of_asyncio)
        _asyncio_entered(state.loop, state.task)
        if sys.get_asyncgen_hooks() != state.hooks:
            sys.set_asyncgen_hooks(*state.hooks)
        if sys.getprofile() is not state.profiling:
            sys.setprofile(state.profiling)
        if sys.gettrace() is not state.tracing:
            sys.settrace(state.tracing)


def _dictionary_of_thread() -> dict[Any, Any]:
    """Return the dictionary in which Python keeps what is a thread's own."""
    api = ctypes.PyDLL(None)
    api.PyThreadState_GetDict.restype = ctypes.c_void_p
    api.PyThreadState_GetDict.argtypes = ()
    address = api.PyThreadState_GetDict()
    dictionary: dict[Any, Any] = ctypes.cast(address, ctypes.py_object).value
    return dictionary


def _local_of_asyncio() -> dict[str, Any]:
    """Return what asyncio keeps for the thread apart from the dictionary of its state."""
    events = sys.modules.get("asyncio.events")
    policy = None if events is None else vars(events).get("_event_loop_policy")
    local = getattr(policy, "_local", None)
    return {} if local is None or _LOCALS_ARE_KEPT else vars(local)


def _taken() -> dict[str, Any]:
    kept = _local_of_asyncio()
    taken = dict(kept)
    kept.clear()
    return taken


def _asyncio_left() -> tuple[Any, Any]:
    """Return the running event loop and its task, which no longer run in this real thread."""
    events = sys.modules.get("asyncio.events")
    tasks = sys.modules.get("asyncio.tasks")
    if events is None or tasks is None:
        return None, None
    loop = vars(events)["_get_running_loop"]()
    if loop is None:
        return None, None
    task = tasks.current_task(loop)
    if task is not None:
        vars(tasks)["_leave_task"](loop, task)
    # Kept beside the dictionary too, for speed.
    vars(events)["_set_running_loop"](None)
    return loop, task


def _asyncio_entered(loop: Any, task: Any) -> None:
    if loop is None:
        return
    vars(sys.modules["asyncio.events"])["_set_running_loop"](loop)
    if task is not None:
        vars(sys.modules["asyncio.tasks"])["_enter_task"](loop, task)
