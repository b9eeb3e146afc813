"""Fork the processes of runs from one that has imported what every run imports.

A server is a process that `tracerisk.common.sandbox.start` has started as any other, and that has
imported the module, but run nothing: no line of a stranger's is read before the fork. A process
that it forks has the same environment, limits and descriptors as one that is started afresh, and
is contained in the same way; the server's own sockets are closed in it.

A run ends with the process that asked for it, and the server with the one that started it.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import select
import signal
import struct
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any

_LONGEST_START_S = 60.0
_GRACE_S = 5.0
_LEAVING_S = 1.0
NUMBER = struct.Struct("=i")
# What a process inherits besides its environment, and cannot be given later.
_INHERITED = frozenset(
    {
        *("Umask", "Uid", "Gid", "Groups", "SigBlk", "SigIgn", "NoNewPrivs", "Seccomp"),
        *("CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb", "Cpus_allowed", "Mems_allowed"),
    }
)

OF_LIBRARIES = ("BLIS_", "LC_", "MKL_", "NUMEXPR_", "NVPL_", "OMP_", "OPENBLAS_")
"""How variables begin on which what a library computes depends, to the last digit."""
READ_ONCE = (
    *OF_LIBRARIES,
    *("PYTHON", "LD_", "LANG", "TZ", "MALLOC_", "GLIBC_", "MUJOCO_", "PYOPENGL_", "LIBCST_"),
    *("GOMP_", "KMP_", "NPY_"),
)
"""How variables begin that Python, the C library and other libraries read once."""

Start = Callable[..., "subprocess.Popen[bytes]"]
"""Starts a process afresh with a plan, an environment and descriptors."""


class Forked(subprocess.Popen[bytes]):
    """A process that a server has forked, which is the server's child and not ours."""

    def __init__(self, arguments: Sequence[str], replies: Any, output: IO[bytes]) -> None:
        """Wait until it is there. Raises OSError where the server cannot fork it."""
        import socket

        self.args = arguments
        self.stdin = self.stderr = None
        self.stdout = output
        self.returncode: int | None = None
        self._replies = replies
        replies.settimeout(_LONGEST_START_S)
        data, descriptors, _, _ = socket.recv_fds(replies, NUMBER.size, 1)
        if not descriptors:
            raise ConnectionError("the server has ended")
        (self.pid,), (self._process,) = NUMBER.unpack(data), descriptors

    def poll(self) -> int | None:
        """Return how it ended; None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self.wait(0)
        return None

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end, at most for a time [s]. Raises TimeoutExpired after that."""
        if self.returncode is None:
            if not is_ready(self._replies.fileno(), timeout):
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
            data = b""
            with contextlib.suppress(ConnectionError):
                data = self._replies.recv(NUMBER.size)
            if data:
                self.returncode = os.waitstatus_to_exitcode(*NUMBER.unpack(data))
            else:
                # The server was killed; what it forked ends by itself.
                if not is_ready(self._process, _GRACE_S):
                    self.send_signal(signal.SIGKILL)
                self.returncode = -signal.SIGKILL
            self._replies.close()
            os.close(self._process)
        return self.returncode

    def send_signal(self, sig: int) -> None:
        """Send it a signal, unless it has ended."""
        if self.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._process, sig)


class _Server:
    """A server that runs, on the side of who asks it."""

    def __init__(self, key: Any, start: Start, plan: Mapping[str, Any], environment: Any) -> None:
        import socket

        self.key = key
        self._environment = dict(environment)
        self._starter = os.getpid()
        self._requests, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            # Its output is as that of a run, which Python looks at when it starts.
            self._process = start(
                {**plan, "requests": theirs.fileno()},
                environment=environment,
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )

    @property
    def is_alive(self) -> bool:
        # Only who started it can ask; to another its end shows at the next request.
        return self._starter != os.getpid() or self._process.poll() is None

    def fork(
        self,
        arguments: Sequence[str],
        plan: Mapping[str, Any],
        environment: Mapping[str, str],
        pass_fds: Sequence[int],
    ) -> Forked:
        """Ask for a process. Raises OSError where the server cannot give it."""
        import socket

        changed = {
            name: environment.get(name)
            for name in {**self._environment, **environment}
            if environment.get(name) != self._environment.get(name)
        }
        asked = {
            "plan": plan,
            "arguments": list(arguments),
            "changed": changed,
            "descriptors": list(pass_fds),
        }
        with contextlib.ExitStack() as on_failure, contextlib.ExitStack() as stack:
            replies, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            # The server ends what it has forked when this end is closed.
            on_failure.callback(replies.close)
            stack.callback(theirs.close)
            reading, writing = os.pipe()
            stack.callback(os.close, writing)
            output = on_failure.enter_context(os.fdopen(reading, "rb"))
            opened = []
            for path, flags in ((os.curdir, os.O_PATH | os.O_DIRECTORY), (os.devnull, os.O_RDWR)):
                opened.append(os.open(path, flags | os.O_CLOEXEC))
                stack.callback(os.close, opened[-1])
            stream = stack.enter_context(tempfile.TemporaryFile())
            stream.write(json.dumps(asked).encode())
            stream.seek(0)
            given = [stream.fileno(), theirs.fileno(), *opened, writing, writing, *pass_fds]
            socket.send_fds(self._requests, [b"."], given)
            stack.close()
            process = Forked(arguments, replies, output)
            on_failure.pop_all()
            return process

    def close(self) -> None:
        """End the server, once its runs have ended."""
        self._requests.close()
        if self._starter == os.getpid():
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(_LEAVING_S)
        if self._process.stdout is not None:
            self._process.stdout.close()


class _Kept:
    """The server of this process, for the latest kind of process that was asked for."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.server: _Server | None = None
        self.key: Any = None
        self.is_wanted = False

    def close(self) -> None:
        server, self.server = self.server, None
        if server is not None:
            server.close()


_KEPT = _Kept()


def several_come() -> None:
    """Start a server with the first process, for there will be more."""
    _KEPT.is_wanted = True


def forked(
    kind: Sequence[str],
    arguments: Sequence[str],
    *,
    plan: Mapping[str, Any],
    environment: Mapping[str, str],
    pass_fds: Sequence[int],
    start: Start,
) -> Forked | None:
    """Return a process that a server has forked; None where one is to be started afresh.

    That is so for the first of its kind, and where there can be no server. `kind` is the module
    with Python's options. Of `environment`, variables that are read once, as a process starts or
    imports a library, are those of the server: another has other ones.
    """
    if sys.platform != "linux" or not hasattr(os, "pidfd_open"):
        return None
    read_once = sorted(item for item in environment.items() if item[0].startswith(READ_ONCE))
    of_server = {"paths": plan["paths"], "owner": os.getpid()}
    with _KEPT.lock:
        try:
            key = (list(kind), read_once, plan["paths"], _inherited())
            server = _KEPT.server
            if server is None or server.key != key or not server.is_alive:
                is_first, _KEPT.key = _KEPT.key != key, key
                if is_first and not _KEPT.is_wanted:
                    return None
                _KEPT.close()
                server = _KEPT.server = _Server(key, start, of_server, environment)
                atexit.unregister(_KEPT.close)
                atexit.register(_KEPT.close)
            return server.fork(arguments, plan, environment, pass_fds)
        except OSError:
            _KEPT.close()
            return None


def _inherited() -> list[str]:
    """Return what a process that starts here inherits, in words of the system."""
    status = Path("/proc/thread-self/status").read_text(encoding="ascii", errors="replace")
    lines = [line for line in status.splitlines() if line.partition(":")[0] in _INHERITED]
    files = [f"/proc/self/{name}" for name in ("limits", "cgroup", "oom_score_adj")]
    texts = [Path(file).read_text(encoding="utf-8", errors="replace") for file in files]
    return [*lines, *texts, str(os.getpriority(os.PRIO_PROCESS, 0))]


def is_ready(descriptor: int, timeout_s: float | None) -> bool:
    """Return whether there is something to read within a time [s]; `None` for all time."""
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(None if timeout_s is None else max(0.0, timeout_s) * 1000))
