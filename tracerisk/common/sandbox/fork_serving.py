"""The process that forks: it takes requests and begins the module in a fork of itself."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from tracerisk.common.sandbox.fork_server import NUMBER

_MOST_DESCRIPTORS = 16


def serve(module: str, plan: Mapping[str, Any]) -> dict[str, Any]:
    """Be a server for a module: return in each process that is forked, with the plan of it.

    In the server itself it does not return. What the module has as `prepare` is called there once.
    """
    me = os.getpid()
    prepare = getattr(import_module(module), "prepare", None)
    if prepare is not None:
        prepare()
    # It is run as `__main__`, and imported by nobody.
    parent, _, name = module.rpartition(".")
    del sys.modules[module]
    if parent:
        vars(sys.modules[parent]).pop(name, None)
    _end_threads()
    numbers = _Jobs(plan["requests"], plan["owner"]).next_forked()
    return _begun(module, numbers, me)


def _end_threads() -> None:
    """End the threads of libraries for linear algebra, which do so before a fork.

    Each process starts them anew when it first needs them.
    """
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)
    if len(list(Path("/proc/self/task").iterdir())) > 1:
        # Nobody knows what they hold at a fork: every process is started afresh.
        os._exit(1)


class _Jobs:
    """The requests that a server gets, and the processes that it has forked for them."""

    def __init__(self, requests: int, owner: int) -> None:
        import socket

        self._requests = socket.socket(fileno=requests)
        self._owner = os.pidfd_open(owner)
        if os.getppid() != owner:
            os._exit(0)
        self._is_open = True
        # The pidfd of each process, with its number and the socket of who asked for it.
        self._running: dict[int, tuple[int, int]] = {}

    def next_forked(self) -> list[int]:
        """Serve until this is a process that was forked; return the descriptors given to it."""
        while self._is_open or self._running:
            poll = select.poll()
            poll.register(self._owner, select.POLLIN)
            if self._is_open:
                poll.register(self._requests, select.POLLIN)
            for process, (_, asker) in self._running.items():
                poll.register(process, select.POLLIN)
                if asker >= 0:
                    poll.register(asker, select.POLLIN)
            ready = {descriptor for descriptor, _ in poll.poll()}
            if self._owner in ready:
                break
            for process, (_, asker) in list(self._running.items()):
                if process in ready:
                    self._ended(process)
                elif asker in ready:
                    self._abandoned(process)
            if self._requests.fileno() in ready:
                numbers = self._asked()
                if numbers is not None:
                    return numbers
        os._exit(0)

    def _asked(self) -> list[int] | None:
        """Fork for one request; return its descriptors in the child, `None` in the server."""
        import socket

        try:
            data, numbers, _, _ = socket.recv_fds(self._requests, 1, _MOST_DESCRIPTORS)
        except OSError:
            data, numbers = b"", []
        if not data:
            self._is_open = False
            return None
        asker = numbers[1]
        try:
            child = os.fork()
        except OSError:
            # Who asked sees that the socket is closed.
            child = -1
        if child == 0:
            # Its number may soon be that of another file.
            self._requests.detach()
            return numbers
        if child > 0:
            process = os.pidfd_open(child)
            self._running[process] = (child, asker)
            with socket.socket(fileno=os.dup(asker)) as replies, contextlib.suppress(OSError):
                socket.send_fds(replies, [NUMBER.pack(child)], [process])
        for number in numbers:
            if number != asker or child < 0:
                os.close(number)
        return None

    def _ended(self, process: int) -> None:
        number, asker = self._running.pop(process)
        _, status = os.waitpid(number, 0)
        os.close(process)
        if asker >= 0:
            with contextlib.suppress(OSError):
                os.write(asker, NUMBER.pack(status))
            os.close(asker)

    def _abandoned(self, process: int) -> None:
        """End a process, for who asked for it is gone."""
        number, asker = self._running[process]
        os.close(asker)
        self._running[process] = (number, -1)
        signal.pidfd_send_signal(process, signal.SIGTERM)


def _begun(module: str, found: Sequence[int], server: int) -> dict[str, Any]:
    """Make this process, which was just forked, what a fresh one would be; return its plan."""
    asked, _, folder, *given = found
    os.setsid()
    os.fchdir(folder)
    with os.fdopen(os.dup(asked)) as stream:
        request = json.load(stream)
    wanted = (0, 1, 2, *request["descriptors"])
    _keep_only(dict(zip(wanted, given, strict=True)))
    for name, value in request["changed"].items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    sys.argv = [module, *request["arguments"]]
    sys.orig_argv = [*sys.orig_argv, *request["arguments"]]
    return {**request["plan"], "parent": server}


def _keep_only(given: Mapping[int, int]) -> None:
    """Give each descriptor the number that it is to have, and close all others."""
    import fcntl

    free = max(given) + 1
    moved = {
        number: fcntl.fcntl(item, fcntl.F_DUPFD_CLOEXEC, free) for number, item in given.items()
    }
    for number, item in moved.items():
        os.dup2(item, number, inheritable=True)
    for path in list(Path("/proc/self/fd").iterdir()):
        if int(path.name) not in given:
            with contextlib.suppress(OSError):
                os.close(int(path.name))
