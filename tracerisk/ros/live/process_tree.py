"""A command and all processes that descend from it: whether they sleep, and their end."""

from __future__ import annotations

import contextlib
import fcntl
import os
import platform
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from tracerisk.common.sandbox.kernel.features import (
    descendants,
    kernel_line,
    processes,
    stat_fields,
)
from tracerisk.ros.live.real_ros import end_process

_LOOK_S = 0.02
"""How often processes that have come are looked for [s]."""
_ALL_S = 1.0
"""How often each process of the machine is asked for its parent, even if none has come [s]."""
_ASKED_S = 0.1
"""How often it is looked whether a thread waits for input [s]."""
_INPUT = f"{63 if platform.machine() == 'aarch64' else 0} 0x0 ".encode()
"""How the kernel begins the line of a thread that waits in read() of the standard input."""
_GRACE_S = 2.0
_POLL_S = 0.02


class ProcessTree:
    """The processes of a command, by whomever they were started.

    To know those whose parents have ended, this process must adopt orphans; `others` returns the
    processes that it started for itself. `answers` are the lines of the command's standard input.
    """

    def __init__(
        self,
        command: Sequence[str],
        environment: Mapping[str, str],
        others: Callable[[], Iterable[int]],
        answers: Sequence[str] = (),
    ) -> None:
        self._others = others
        self._seen: tuple[int, ...] = ()
        self._seen_at = self._known_at = 0.0
        self._known: set[int] = set()
        self._ran: dict[int, int] = {}
        self._asked_at = 0.0
        reads, self._writes = os.pipe()
        text = "".join(f"{answer}\n" for answer in answers).encode()
        # Room for all of them: nobody reads yet.
        fcntl.fcntl(self._writes, fcntl.F_SETPIPE_SZ, max(len(text), 1))
        os.write(self._writes, text)
        self._process = subprocess.Popen(
            command, env=dict(environment), stdin=reads, close_fds=True
        )
        os.close(reads)

    @property
    def pid(self) -> int:
        """The process of the command itself."""
        return self._process.pid

    @property
    def code(self) -> int | None:
        """The return code of the command, negative for a signal; None while it lives."""
        return self._process.poll()

    @property
    def pids(self) -> tuple[int, ...]:
        """The processes that live, as seen a moment ago."""
        if time.monotonic() - self._seen_at > _LOOK_S:
            self._look()
        return self._seen

    def computed_ns(self) -> int:
        """Return how long the busiest thread has computed since this was asked last [ns]."""
        now = {task: ran for pid in self.pids for task, ran in _ran(pid)}
        since = max((ran - self._ran.get(task, ran) for task, ran in now.items()), default=0)
        self._ran = now
        return since

    def end_input(self) -> bool:
        """End the standard input once a thread waits for more of it; return whether it was now."""
        if self._writes < 0 or time.monotonic() - self._asked_at < _ASKED_S:
            return False
        self._asked_at = time.monotonic()
        if not any(_reads_input(pid) for pid in self.pids):
            return False
        self._close_input()
        return True

    def _close_input(self) -> None:
        if self._writes >= 0:
            os.close(self._writes)
            self._writes = -1

    def end(self) -> None:
        """End all processes: the command by an interrupt, then what is left by stronger signals."""
        end_process(self._process, signal.SIGINT)
        self._close_input()
        for number in (signal.SIGTERM, signal.SIGKILL):
            self._look()
            for pid in self._seen:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, number)
            until = time.monotonic() + _GRACE_S
            while self._seen and time.monotonic() < until:
                time.sleep(_POLL_S)
                self._look()

    def _look(self) -> None:
        self._seen_at = time.monotonic()
        there = set(processes())
        pids: Iterable[int] = self._seen
        # To ask every process of the machine for its parent takes long. A stranger becomes none of
        # ours, but its number may be given to one of ours.
        if not there <= self._known or self._seen_at - self._known_at > _ALL_S:
            self._known, self._known_at = there, self._seen_at
            pids = descendants(os.getpid(), frozenset(self._others()))
        self._seen = tuple(pid for pid in pids if pid in there and not self._is_reaped(pid))

    def _is_reaped(self, pid: int) -> bool:
        """Return whether a process has ended; one that we have adopted is taken off the table."""
        if pid == self._process.pid:
            return self._process.poll() is not None
        with contextlib.suppress(ChildProcessError):
            return os.waitpid(pid, os.WNOHANG)[0] == pid
        return False


def has_ended(pid: int) -> bool:
    """Return whether a process is there no more, or is only waited for."""
    try:
        return stat_fields(f"/proc/{pid}")[0] in b"ZX"
    except OSError:
        return True


def _ran(pid: int) -> Iterator[tuple[int, int]]:
    """Yield the threads of a process, and the time that each has had a processor [ns]."""
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        for task in os.scandir(f"/proc/{pid}/task"):
            with contextlib.suppress(FileNotFoundError, ProcessLookupError):
                yield int(task.name), int(kernel_line(f"{task.path}/schedstat").split()[0])


def _reads_input(pid: int) -> bool:
    with contextlib.suppress(OSError):
        for task in os.scandir(f"/proc/{pid}/task"):
            with contextlib.suppress(OSError):
                if kernel_line(f"{task.path}/syscall").startswith(_INPUT):
                    return True
    return False
