"""Run commands of tests as a user's shell would, without importing everything anew for each.

One process imports what commands import. It forks one process a command, which gets a folder,
arguments, an environment and three streams, and ends as `python -m tracerisk` would, or at the
latest with whoever asked for it. A program in a shell can ask for one too, and hands on the signals
that it gets. The commands' runs of controllers are forked by one server in turn
(`tracerisk.common.sandbox.fork_server`), and their workers by themselves.
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
import weakref
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import _lru_cache_wrapper
from importlib import import_module
from multiprocessing.connection import Connection
from multiprocessing.context import ForkContext, ForkProcess
from pathlib import Path
from pkgutil import iter_modules

from tracerisk import cli
from tracerisk.common.sandbox.fork_server import READ_ONCE, several_come
from tracerisk.pipeline.evidence import workers

_LONGEST_S = 300.0

# What a shell starts as `tracerisk`: it asks for a command with its own streams.
_PROGRAM = """\
#!{python} -IS
import json, os, signal, socket, sys
given = os.memfd_create("given")
os.write(given, json.dumps([os.getcwd(), sys.argv[1:], dict(os.environ)]).encode())
os.lseek(given, 0, os.SEEK_SET)
with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as server:
    server.connect({path!r})
    socket.send_fds(server, [b"."], [given, 0, 1, 2])
    command = int(server.recv(16))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: os.kill(command, number))
    code = int(server.recv(16))
sys.exit(code if code >= 0 else 128 - code)
"""


class Commands:
    """The process that forks commands, on the side of the tests."""

    def __init__(self, path: str, environment: Mapping[str, str]) -> None:
        """Ask the process that listens at a path, and was started in an environment.

        Runs with other variables that are read once have a server of their own.
        """
        self.path = path
        self.program = str(Path(path).with_name("tracerisk"))
        self._once = _read_once(environment)

    @classmethod
    def started(cls, controller: str, environment: Mapping[str, str]) -> Commands:
        """Start it; it imports what a run of the controller, and a report on it, import.

        It ends with this process. What is asked meanwhile waits until it has begun.
        """
        folder = tempfile.TemporaryDirectory()
        commands = cls(str(Path(folder.name, "commands")), environment)
        life, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs, _socket() as listener:
            listener.bind(commands.path)
            listener.listen()
            numbers = (theirs.fileno(), listener.fileno())
            process = subprocess.Popen(
                [sys.executable, __file__, *map(str, numbers), controller],
                pass_fds=numbers,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
                env=environment,
            )
        program = Path(commands.program)
        program.write_text(_PROGRAM.format(python=sys.executable, path=commands.path))
        program.chmod(0o755)

        def end() -> None:
            life.close()
            process.wait(60)
            folder.cleanup()

        atexit.register(end)
        return commands

    def can_run(self, environment: Mapping[str, str]) -> bool:
        return _read_once(environment) == self._once

    def run(
        self,
        folder: Path,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        *,
        script: Path | None = None,
    ) -> tuple[int, bytes, bytes]:
        """Return the exit code of a command, and what it wrote to both of its streams.

        With `script`, it is that file, run by Python.
        """
        path = None if script is None else str(script)
        asked = json.dumps([str(folder), list(arguments), dict(environment), path]).encode()
        with (
            _socket() as server,
            Path(os.devnull).open("rb") as nothing,
            tempfile.TemporaryFile() as given,
            tempfile.TemporaryFile() as out,
            tempfile.TemporaryFile() as err,
        ):
            given.write(asked)
            given.seek(0)
            server.connect(self.path)
            socket.send_fds(server, [b"."], [each.fileno() for each in (given, nothing, out, err)])
            server.settimeout(_LONGEST_S)
            if not server.recv(16):  # its process number
                raise RuntimeError("no command can be run; standard error says why")
            code = int(server.recv(16))
            out.seek(0)
            err.seek(0)
            return code, out.read(), err.read()


def _socket() -> socket.socket:
    return socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def _read_once(environment: Mapping[str, str]) -> dict[str, str]:
    return {name: each for name, each in environment.items() if name.startswith(READ_ONCE)}


def _serve(life: socket.socket, listener: socket.socket) -> None:
    """Fork commands until nobody can ask for one."""
    # Of each command by the number of its process's descriptor: its process, and who has asked.
    running: dict[int, tuple[int, socket.socket]] = {}
    # The descriptor of a command's process by that of who has asked.
    asked: dict[int, int] = {}
    poll = select.poll()
    for each in (life, listener):
        poll.register(each, select.POLLIN)
    while True:
        # One at a time: what ends one may give its number to another.
        ready, _ = poll.poll()[0]
        if ready == life.fileno():
            for process in running:
                signal.pidfd_send_signal(process, signal.SIGKILL)
            return
        if ready in running:
            poll.unregister(ready)
            number, asking = running.pop(ready)
            if asked.pop(asking.fileno(), None):
                poll.unregister(asking)
            code = os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
            with asking, suppress(OSError):
                asking.send(str(code).encode())
            os.close(ready)
            continue
        if ready in asked:
            poll.unregister(ready)
            signal.pidfd_send_signal(asked.pop(ready), signal.SIGKILL)
            continue
        asking = listener.accept()[0]
        _, found, _, _ = socket.recv_fds(asking, 1, 4)
        number = os.fork()
        if number == 0:
            for other in (life, listener, asking, *(each for _, each in running.values())):
                other.close()
            for process in running:
                os.close(process)
            _command(*found)
        for given in found:
            os.close(given)
        process = os.pidfd_open(number)
        running[process] = (number, asking)
        asked[asking.fileno()] = process
        poll.register(process, select.POLLIN)
        # No event but that it has gone.
        poll.register(asking, 0)
        with suppress(OSError):
            asking.send(str(number).encode())


def _command(given: int, *streams: int) -> None:
    """Be a command to the end of its process."""
    with os.fdopen(given) as stream:
        folder, arguments, environment, *script = json.load(stream)
    for number, each in enumerate(streams):
        os.dup2(each, number)
        os.close(each)
    sys.stdout.reconfigure(line_buffering=os.isatty(1))
    os.environ.clear()
    os.environ.update(environment)
    code = _ended(folder, arguments, *script)
    with suppress(BaseException):
        threading._shutdown()
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _ended(folder: str, arguments: Sequence[str], script: str | None = None) -> int:
    """Run a command, or a script; return its exit code."""
    os.chdir(folder)
    sys.path[0] = folder if script is None else str(Path(script).parent)
    sys.argv = ["-m" if script is None else script, *arguments]
    try:
        if script is None:
            runpy.run_module("tracerisk", run_name="__main__", alter_sys=True)
        else:
            runpy.run_path(script, run_name="__main__")
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


class _Worker(ForkProcess):
    """A process of a pool that is forked, and has nothing of the command's but what it is given."""

    def _bootstrap(self, parent_sentinel: int | None = None) -> int:
        # In this order: a folder that nothing holds any more is removed by its finalizer.
        weakref.finalize._registry.clear()
        atexit._clear()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        given = [each for part in self._args if isinstance(part, tuple) for each in part]
        for each in given:
            if isinstance(each, Connection):
                _close_the_other_end(each.fileno())
        return super()._bootstrap(parent_sentinel=parent_sentinel)


class ForkedWorkers(ForkContext):
    """Starts the workers of a pool without importing everything anew for each."""

    Process = _Worker


def _close_the_other_end(kept: int) -> None:
    """Close the end of a pipe that is the parent's: with the parent it is to be gone."""
    pipe = os.stat(kept)
    for number in [int(each.name) for each in Path("/proc/self/fd").iterdir()]:
        with suppress(OSError):
            if number != kept and os.path.samestat(os.fstat(number), pipe):
                os.close(number)


def _main() -> None:
    life, listener = (socket.socket(fileno=int(number)) for number in sys.argv[1:3])
    for each in (life, listener):
        os.set_inheritable(each.fileno(), False)
    several_come()
    os.fsync = lambda _: None  # no machine fails during a test, and each would wait for its disk
    for verb in iter_modules(cli.__path__):
        import_module(f"{cli.__name__}.{verb.name}")
    # The first run starts the server of runs, which the commands inherit.
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "c.py").write_text(sys.argv[3])
        for line in (
            "run c.py --quiet",
            "solve c.py",
            "report c.py -o r.html --quiet",
            "hardware init --robot panda -o h.yaml --quiet",
            "hardware show h.yaml",
            "doctor c.py",
        ):
            code = _ended(folder, line.split())
            if code:
                sys.exit(f"{line}: ended with {code}")
        os.chdir("/")
    workers._CONTEXT = ForkedWorkers()
    with suppress(ImportError):
        import_module("tracerisk.editor.server")
    for each in gc.get_objects():
        if isinstance(each, _lru_cache_wrapper) and each.__module__.startswith("tracerisk"):
            each.cache_clear()
    tempfile.tempdir = None
    gc.collect()
    gc.freeze()
    _serve(life, listener)
    os._exit(0)


if __name__ == "__main__":
    _main()
