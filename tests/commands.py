"""Run commands of tests as a user's shell would, without importing everything anew for each.

One process imports what commands import. It forks one process a command, which gets a folder,
arguments and an environment, and ends as `python -m tracerisk` would. The commands' runs of
controllers are forked by one server in turn (`tracerisk.sandbox.fork_server`).
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import _lru_cache_wrapper
from pathlib import Path

_LONGEST_S = 300.0
# Python and the system's libraries look at these when they start, and never again.
_READ_AT_START = ("PYTHON", "LC_", "LANG", "TZ", "OMP_", "OPENBLAS_", "MUJOCO_", "LD_")


class Commands:
    """The process that forks commands, on the side of the tests."""

    def __init__(self, controller: str) -> None:
        """Start it; it imports what a run of the controller, and a report on it, import."""
        self._at_start = _read_at_start(os.environ)
        self._requests, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, __file__, str(theirs.fileno()), controller],
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
            )
        if self._requests.recv(1) != b"+":
            raise RuntimeError("no command can be run; standard error says why")
        atexit.register(self.close)

    def can_run(self, environment: Mapping[str, str]) -> bool:
        return _read_at_start(environment) == self._at_start

    def run(
        self, folder: Path, arguments: Sequence[str], environment: Mapping[str, str]
    ) -> tuple[int, bytes, bytes]:
        """Return the exit code of a command, and what it wrote to both of its streams."""
        asked = json.dumps([str(folder), list(arguments), dict(environment)]).encode()
        answers, theirs = socket.socketpair()
        with (
            answers,
            tempfile.TemporaryFile() as given,
            tempfile.TemporaryFile() as out,
            tempfile.TemporaryFile() as err,
        ):
            with theirs:
                given.write(asked)
                given.seek(0)
                files = [each.fileno() for each in (given, out, err, theirs)]
                socket.send_fds(self._requests, [b"."], files)
            answers.settimeout(_LONGEST_S)
            code = int(answers.recv(16))
            out.seek(0)
            err.seek(0)
            return code, out.read(), err.read()

    def close(self) -> None:
        self._requests.close()
        self._process.wait(60)


def _read_at_start(environment: Mapping[str, str]) -> dict[str, str]:
    return {name: each for name, each in environment.items() if name.startswith(_READ_AT_START)}


def _serve(requests: socket.socket) -> None:
    """Fork commands until nobody can ask for one."""
    running: dict[int, tuple[int, int]] = {}
    poll = select.poll()
    poll.register(requests, select.POLLIN)
    while True:
        for ready, _ in poll.poll():
            if ready in running:
                poll.unregister(ready)
                number, answers = running.pop(ready)
                code = os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
                with suppress(OSError):
                    os.write(answers, str(code).encode())
                os.close(answers)
                os.close(ready)
                continue
            reported, found, _, _ = socket.recv_fds(requests, 1, 4)
            if not reported:
                for process in running:
                    signal.pidfd_send_signal(process, signal.SIGKILL)
                return
            number = os.fork()
            if number == 0:
                for each in (requests.detach(), found[3], *running):
                    os.close(each)
                for _, answers in running.values():
                    os.close(answers)
                _command(*found[:3])
            for each in found[:3]:
                os.close(each)
            process = os.pidfd_open(number)
            running[process] = (number, found[3])
            poll.register(process, select.POLLIN)


def _command(given: int, out: int, err: int) -> None:
    """Be a command to the end of its process."""
    with os.fdopen(given) as stream:
        folder, arguments, environment = json.load(stream)
    for number, each in ((1, out), (2, err)):
        os.dup2(each, number)
        os.close(each)
    os.environ.clear()
    os.environ.update(environment)
    code = _ended(folder, arguments)
    with suppress(BaseException):
        threading._shutdown()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _ended(folder: str, arguments: Sequence[str]) -> int:
    """Run a command; return its exit code."""
    os.chdir(folder)
    sys.path[0] = folder
    sys.argv = ["-m", *arguments]
    try:
        runpy.run_module("tracerisk", run_name="__main__", alter_sys=True)
    except SystemExit as end:
        if isinstance(end.code, str):
            sys.stderr.write(f"{end.code}\n")
            return 1
        return end.code or 0
    except KeyboardInterrupt:
        return 130
    except BaseException:  # noqa: BLE001 - as Python does with any
        sys.excepthook(*sys.exc_info())
        return 1
    return 0


def _main() -> None:
    requests = socket.socket(fileno=int(sys.argv[1]))
    os.set_inheritable(requests.fileno(), False)
    from tracerisk.sandbox.fork_server import several_come

    several_come()
    # The first run starts the server of runs, which the commands inherit.
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "c.py").write_text(sys.argv[2])
        for words in (["run", "c.py", "--quiet"], ["report", "c.py", "--output", "r.html"]):
            code = _ended(folder, words)
            if code:
                sys.exit(f"{words} ended with {code}")
        os.chdir("/")
    for each in gc.get_objects():
        if isinstance(each, _lru_cache_wrapper):
            each.cache_clear()
    tempfile.tempdir = None
    gc.collect()
    gc.freeze()
    requests.send(b"+")
    _serve(requests)
    os._exit(0)


if __name__ == "__main__":
    _main()
