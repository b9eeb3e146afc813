"""The one boundary at which errors become a message and an exit code."""

from __future__ import annotations

import errno
import os
import signal
import sys
import warnings
from importlib import import_module

from tracerisk.cli.shared.output import note, place_data, print_json, scenario_advice
from tracerisk.cli.verbs import module_of
from tracerisk.common.text.printable import escaped, printable
from tracerisk.errors import (
    ExitCode,
    TraceRiskError,
    disk_full,
    file_limited,
    interruption,
    with_file,
)

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import NoReturn

_format = warnings.formatwarning


def guarded(options: argparse.Namespace) -> int:
    """Run the chosen verb and return its exit code."""
    try:  # noqa: SIM105 - no start needs contextlib
        signal.signal(signal.SIGTERM, _terminated)
    except ValueError:  # only the main thread may say what signals do
        pass
    warnings.formatwarning = _one_line
    # The options speak to the tables, the progress bar and the libraries alike in these words.
    if getattr(options, "color", "auto") != "auto":
        os.environ.pop("NO_COLOR", None)
        os.environ["FORCE_COLOR" if options.color == "always" else "NO_COLOR"] = "1"
    try:
        return int(import_module(module_of(options.verb)).run(options))
    except BrokenPipeError:
        raise
    except Exception as error:  # noqa: BLE001 - the one boundary
        if (ended := interruption(error)) is not None:
            raise ended from None
        known = _known(error, options.verb)
        return _internal_error() if known is None else _failed(options, known)


def _known(error: Exception, verb: str) -> TraceRiskError | None:
    """Return the error that says what to do, `None` for an internal one."""
    if isinstance(error, TraceRiskError):
        return error
    if isinstance(error, ImportError):
        # Imported here: a start-up that goes well does without it.
        from tracerisk.common.dependencies import error_of

        return error_of(error, f"`tracerisk {verb}`")
    if isinstance(error, OSError) and error.errno == errno.ENOSPC:
        return disk_full(str(error.filename or "the temporary files"))
    if isinstance(error, OSError) and error.errno == errno.EFBIG:
        return file_limited()
    return None


def _one_line(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    line: str | None = None,
) -> str:
    """Print our own warnings as everything else that we say."""
    if category.__module__.partition(".")[0] == "tracerisk":
        return f"{printable(f'tracerisk: warning: {message}')}\n"
    return _format(message, category, filename, lineno, line)


def _failed(options: argparse.Namespace, error: TraceRiskError) -> int:
    error.location = with_file(error.location, _typed)
    note(f"tracerisk: {error.with_code}")
    if scenario := getattr(error, "scenario", ""):
        note(scenario_advice(scenario))
    if getattr(options, "json", False):
        print_json(options.verb, exit_code=int(error.exit_code), error=_error_data(error))
    return int(error.exit_code)


def _typed(file: str) -> str:
    """Return a file of a message as a user would type it here: a setting names it in full."""
    from pathlib import Path

    from tracerisk.config import from_here

    return from_here(Path())(file) if Path(file).is_absolute() else file


def _internal_error() -> int:
    import traceback

    from tracerisk.cli.shared.error_log import write_error_log

    lines = traceback.format_exc()
    sys.stderr.write(escaped(lines))
    log = write_error_log(lines)
    what = "the lines above" if log is None else f"the file {log}"
    note(f"tracerisk: this is an internal error of tracerisk; please report it with {what}")
    return int(ExitCode.INTERNAL_FAULT)


def _terminated(number: int, _: object) -> NoReturn:
    # As Ctrl-C: the controller's process ends with us, and temporary files go.
    sys.exit(128 + number)


def _error_data(error: TraceRiskError) -> dict[str, object]:
    return {
        "kind": type(error).__name__,
        "code": error.code,
        "message": error.message,
        **place_data(error.location),
        "scenario": getattr(error, "scenario", "") or None,
    }
