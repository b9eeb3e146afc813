"""Start a module of ours in a contained process: `python -s start.py DESCRIPTOR MODULE ARG...`.

The descriptor is that of a file with the plan, as JSON: see `tracerisk.common.sandbox.process`.
This process stays behind as the parent of the one that runs the module. When either that one or
the parent of both ends, it ends whatever the module has started and ends in the same way itself.
"""

from __future__ import annotations

import sys

if __name__ == "__main__":
    # The folder of a script goes before the standard library; nothing is imported from this one.
    del sys.path[0]

import atexit
import contextlib
import gc
import importlib.util
import json
import os
import runpy
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn


def _import_own() -> None:
    """Import tracerisk from where this file is, whatever else has its name."""
    folder = Path(__file__).resolve().parents[2]
    spec = importlib.util.spec_from_file_location(
        "tracerisk", folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    if spec is None or spec.loader is None:
        raise ImportError(f"tracerisk is not installed in {folder}")
    package = importlib.util.module_from_spec(spec)
    sys.modules["tracerisk"] = package
    spec.loader.exec_module(package)


if __name__ == "__main__":
    # The first import of a part of it would take the whole from where Python is set up to look.
    _import_own()

from tracerisk.common.sandbox.files import held_files
from tracerisk.common.sandbox.fork_serving import serve
from tracerisk.common.sandbox.kernel import control_groups
from tracerisk.common.sandbox.kernel import features as kernel

_ROUNDS = 200


def main() -> None:
    """Run the module that the command line names."""
    end = _End()
    with os.fdopen(int(sys.argv[1])) as stream:
        plan = json.load(stream)
    module = sys.argv[2]
    sys.argv = sys.argv[2:]
    sys.path += [folder for folder in plan["paths"] if folder not in sys.path]
    if "requests" in plan:
        # What follows is done by each process that it forks.
        plan = serve(module, plan)
    if sys.platform == "linux":
        _stay_behind(plan)
        if plan["readable"] is not None:
            _restrict(plan)
    # What is imported stays, and to look through it takes longer than many a run: the module turns
    # the collection of garbage on when its work begins.
    gc.disable()
    with end.code_noted():
        runpy.run_module(module, run_name="__main__", alter_sys=True)


class _End:
    """The end of a process after all that was to be done at exit, with no object taken apart.

    To free what hundreds of modules hold takes as long as a short run. What the system takes back
    anyway is left to it.
    """

    def __init__(self) -> None:
        self._code = 1
        # What is registered first is called last.
        atexit.register(self._leave, os._exit)

    @contextlib.contextmanager
    def code_noted(self) -> Iterator[None]:
        try:
            yield
        except SystemExit as error:
            self._code = error.code if isinstance(error.code, int) else int(error.code is not None)
            raise
        self._code = 0

    def _leave(self, leave: Callable[[int], NoReturn]) -> None:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(AttributeError, OSError, ValueError):
                stream.flush()
        with contextlib.suppress(ImportError, MemoryError, OSError):
            import ctypes

            ctypes.CDLL(None).fflush(None)
        leave(self._code)


def _stay_behind(plan: dict[str, Any]) -> None:
    """Return in a new process; this one waits for its end, and ends with it."""
    parent = plan["parent"]
    kernel.adopt_orphans()
    kernel.die_with_parent(signal.SIGTERM)
    is_contained = plan["readable"] is not None
    keeps_in = is_contained and kernel.keep_signals_in(kernel.support().landlock)
    me = os.getpid()
    memory_bytes = plan.get("memory_bytes")
    group = None
    if is_contained and memory_bytes is not None:
        group = control_groups.new_group(control_groups.group_folder(), memory_bytes)

    def stop(*_: object) -> NoReturn:
        control_groups.end_group(group)
        _end_descendants(me, all_at_once=keeps_in)
        control_groups.end_group(group)
        os._exit(128 + signal.SIGTERM)

    if os.getppid() != parent:
        os._exit(128 + signal.SIGTERM)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    child = os.fork()
    if child == 0:
        control_groups.enter_group(group)
        kernel.die_with_parent(signal.SIGKILL)
        if os.getppid() != me:
            os._exit(1)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
        return
    signal.signal(signal.SIGTERM, stop)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    _close_all()
    status = _end_of(child)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    control_groups.end_group(group)
    _end_descendants(me, all_at_once=keeps_in)
    control_groups.end_group(group)
    _end_as(status)


def _close_all() -> None:
    """Close every file: whoever waits for their end waits for that of the module alone."""
    for number in (0, 1, 2):
        with contextlib.suppress(OSError):
            os.close(number)
    os.closerange(3, 1024)


def _end_of(child: int) -> int:
    """Return the status with which a process ended; others that end meanwhile are reaped."""
    while True:
        result, status = os.waitpid(-1, 0)
        if result == child:
            return status


def _end_descendants(me: int, *, all_at_once: bool) -> None:
    """End every process that descends from this one.

    `all_at_once`: a signal of this process reaches no other, so one to all ends them.
    """
    for _ in range(_ROUNDS):
        if all_at_once:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(-1, signal.SIGKILL)
        else:
            for number in (signal.SIGSTOP, signal.SIGKILL):
                for descendant in kernel.descendants(me):
                    with contextlib.suppress(ProcessLookupError, PermissionError):
                        os.kill(descendant, number)
        try:
            while os.waitpid(-1, 0 if all_at_once else os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return


def _end_as(status: int) -> NoReturn:
    """End this process in the way in which another has ended."""
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        with contextlib.suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {number})
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.kill(os.getpid(), number)
        os._exit(128 + number)
    os._exit(os.waitstatus_to_exitcode(status))


def _restrict(plan: dict[str, Any]) -> None:
    held = held_files.hold(plan["held"])
    try:
        kernel.restrict(
            [*plan["readable"], *held.values()],
            plan["listable"],
            plan["writable"],
            own_network=plan["speaks"] and kernel.leave_network(),
        )
    except OSError as error:
        sys.exit(f"the sandbox cannot be set up here ({error.strerror}); see tracerisk doctor")
    held_files.serve(held)


if __name__ == "__main__":
    main()
