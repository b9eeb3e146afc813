"""The command `tracerisk`: one file a verb, one place where errors become exit codes.

No verb is imported before it is chosen, and no parser where a verb has paths alone to read.
"""

from __future__ import annotations

import _thread
import gc
import io
import os
import sys
import time
from collections.abc import Sequence
from importlib import import_module
from types import SimpleNamespace

from tracerisk.cli.verbs import module_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

_MADE_BEFORE_A_LOOK = 100_000  # objects, in place of 700
_CTRL_C, _END = 2, 15  # numbers of signals, on every system
_SOON_S = 0.01
_AT_THE_END = {"atexit", "threading"}  # what is to be done, or waited for, when a process ends


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    if arguments is not None:
        return _guarded(list(arguments))
    # The process is ours: most of what a command makes it keeps to its end, and nobody is to look
    # through it again and again for what might be thrown away.
    gc.set_threshold(_MADE_BEFORE_A_LOOK)
    sys.unraisablehook = _raised_once_more
    if "PYTHONPATH" in os.environ:
        # A sourced ROS may have other versions there of what we import.
        from tracerisk.common.sandbox.ros_prefix import without_ros

        sys.path[:] = without_ros(sys.path)
    try:
        code = _guarded(sys.argv[1:])
    finally:
        gc.freeze()
    if not _AT_THE_END.intersection(sys.modules):
        # Nobody has anything to do at the end: free no object by itself before all memory goes.
        sys.stderr.flush()
        os._exit(code)
    return code


def _guarded(given: list[str]) -> int:
    # A stream that was closed before the start is `None` here.
    sys.stdin = sys.stdin or open(os.devnull)  # noqa: PTH123, SIM115 - lives as long as we
    sys.stdout = sys.stdout or open(os.devnull, "w")  # noqa: PTH123, SIM115
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: PTH123, SIM115
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        # A pipe of Windows has the encoding of its region, which lacks most characters.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        return _run(given)
    except KeyboardInterrupt:
        return _interrupted()
    except BrokenPipeError:
        # The reader of our output has gone; there is nobody left to print for.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        from tracerisk.errors import interruption

        # One that came while a verb was imported, of which Python makes another error.
        ended = interruption(error)
        if isinstance(ended, KeyboardInterrupt):
            return _interrupted()
        if ended is not None:
            raise ended from None
        raise


def _interrupted() -> int:
    print("tracerisk: interrupted", file=sys.stderr)
    return 130


def _raised_once_more(dropped: sys.UnraisableHookArgs) -> None:
    """Raise a Ctrl-C or an end once more where Python has dropped it.

    It drops what is raised in callbacks of weak references, of which each import has one, and as
    objects go.
    """
    error = dropped.exc_value
    is_end = isinstance(error, SystemExit) and error.code == 128 + _END
    if not is_end and not isinstance(error, KeyboardInterrupt):
        sys.__unraisablehook__(dropped)
        return
    number = _END if is_end else _CTRL_C
    # Here it would be dropped again.
    _thread.start_new_thread(_interrupt_soon, (_thread.get_ident(), number))


def _interrupt_soon(thread: int, number: int) -> None:
    import signal

    time.sleep(_SOON_S)
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(thread, number)  # this wakes it too where it waits
    else:
        _thread.interrupt_main(signal.Signals(number))


def _run(given: list[str]) -> int:
    try:
        options = _plain(given)
        if options is None:
            from tracerisk.cli.parser import parse

            options = parse(given)
        from tracerisk.cli.boundary import guarded

        return guarded(options)
    finally:
        # What is still buffered may meet a broken pipe; `main` is where that is caught.
        sys.stdout.flush()


def _plain(given: list[str]) -> argparse.Namespace | None:
    """Return the options of a verb that has files alone, or `-q`; `None` for all else.

    A hook runs `check` at every commit, and a script `solve` for many a model: they are not to
    wait for a parser of everything.
    """
    files = [word for word in given[1:] if word not in ("-q", "--quiet")]
    is_plain = not any(word.startswith("-") for word in files)
    if (
        not is_plain
        or given[:1] not in (["check"], ["solve"])
        or (given[0] == "solve" and not files)
    ):
        return None
    defaults = _Defaults()
    import_module(module_of(given[0])).add_options(defaults)
    stated = {"verb": given[0], "version": None, "files": files}
    is_quiet = len(files) + 1 < len(given)
    plain: Any = SimpleNamespace(**{**defaults.values, **stated, "quiet": is_quiet})
    return plain  # type: ignore[no-any-return]


class _Defaults:
    """Takes the options of a verb as a parser does, and keeps what they are where none is given."""

    def __init__(self) -> None:
        self.values: dict[str, Any] = {}

    def add_argument(
        self, *names: str, dest: str = "", default: Any = None, action: str = "", **_: Any
    ) -> None:
        name = next((text for text in names if text.startswith("--")), names[-1])
        dest = dest or name.lstrip("-").replace("-", "_")
        self.values[dest] = False if action == "store_true" else default

    def add_argument_group(self, *_: str) -> _Defaults:
        return self
