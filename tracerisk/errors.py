"""The errors that tracerisk raises on purpose.

Every message says where, what was found, what is allowed and what to do.
Anything else that escapes is an internal error (exit code 5).
"""

from __future__ import annotations

import contextlib
import enum
import signal
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

_MOST_NAMES = 50


class ExitCode(enum.IntEnum):
    """Exit codes of the command `tracerisk`."""

    FINE = 0
    WOULD_CHANGE = 1
    BAD_INPUT = 2
    EDIT_IN_THE_WAY = 3
    CONTROLLER_FAILED = 4
    INTERNAL_FAULT = 5
    INTERRUPTED = 130


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a file."""

    file: str
    """The path of the file, as a message names it."""
    line: int | None = None
    """The line, counted from 1; `None` for the whole file."""
    column: int | None = None
    """The column in the line, counted from 1; `None` for the whole line."""

    def __str__(self) -> str:
        return ":".join(
            str(part) for part in (self.file, self.line, self.column) if part is not None
        )


def with_file(place: Location | None, file_of: Callable[[str], str]) -> Location | None:
    """Return a place with another name of its file; `file_of` takes a file."""
    return None if place is None else Location(file_of(place.file), place.line, place.column)


def with_line(place: Location | None, line_of: Callable[[str, int], int]) -> Location | None:
    """Return a place on another line of its file; `line_of` takes a file and a line of it."""
    if place is None or place.line is None:
        return place
    return Location(place.file, line_of(place.file, place.line), place.column)


def signal_name(number: int) -> str:
    """Return what messages call a signal of the system: most of those of real time have no name."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


class TraceRiskError(Exception):
    """Base of every error that tracerisk raises on purpose.

    `location` is where the cause stands, when it stands in a file; `code` names the kind of error
    in messages, JSON and docs/errors.md, and stays what it is.
    """

    exit_code = ExitCode.BAD_INPUT
    code: str = "error"

    def __init__(self, message: str, location: Location | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.location = location

    def __str__(self) -> str:
        return self.message if self.location is None else f"{self.location}: {self.message}"

    @property
    def with_code(self) -> str:
        """The message with its place, and the code at its end."""
        return f"{self} [{self.code}]"


class InputError(TraceRiskError, ValueError):
    """A file, a value or an option holds something that is not allowed."""

    code = "input"


class SettingsError(InputError):
    """A setting in `[tool.tracerisk]` is unknown or has a bad value."""

    code = "settings"


class SourceError(InputError):
    """A source file cannot be read as the language it should hold."""

    code = "source"


class BlockError(InputError):
    """A risk annotation block is malformed."""

    code = "block"


class UnpinnedReasonError(BlockError):
    """A value of the tool's has a reason: a user edited it, and did not write `:=`."""

    exit_code = ExitCode.EDIT_IN_THE_WAY
    code = "reason"


class UnsafeRewriteError(InputError):
    """A source file cannot be rewritten with proof that nothing else changes."""

    code = "rewrite"


class HardwareError(InputError):
    """A hardware description is malformed, or does not fit the robot."""

    code = "hardware"


class RobotError(InputError):
    """A robot or a scene description is malformed or unknown."""

    code = "robot"


class ScenarioError(InputError):
    """A scenario or a parameter file is malformed, or does not fit the controller's messages."""

    code = "scenario"


class DriverError(InputError):
    """The description of a driver is malformed, or does not fit the messages it speaks of."""

    code = "driver"


class SandboxError(InputError):
    """A sandbox, or a network without others, is required that the system does not allow."""

    code = "sandbox"


class LogError(InputError):
    """A trace or a log file is malformed."""

    code = "log"


class ModelError(InputError):
    """A risk model is malformed or has no solution."""

    code = "model"


class DependencyError(TraceRiskError, ImportError):
    """A package that tracerisk depends on cannot be imported."""

    code = "dependency"


class OtherSystemError(TraceRiskError, NotImplementedError):
    """What was asked for works on another operating system alone."""

    code = "system"


class RenderError(TraceRiskError, RuntimeError):
    """Pictures cannot be drawn on this machine."""

    code = "render"


class TooLargeError(ModelError):
    """A model outgrew every budget of exact solution; the message says what was tried.

    `lower` and `upper` bound the probability asked for, where bounds could be had.
    """

    code = "too-large"

    def __init__(
        self,
        message: str,
        location: Location | None = None,
        *,
        lower: float | None = None,
        upper: float | None = None,
    ) -> None:
        super().__init__(message, location)
        self.lower = lower
        self.upper = upper


class EditInTheWayError(TraceRiskError, PermissionError):
    """A user edited a computed value; writing would lose the edit."""

    exit_code = ExitCode.EDIT_IN_THE_WAY
    code = "edit"

    def __str__(self) -> str:
        return TraceRiskError.__str__(self)


class ControllerFailedError(TraceRiskError, RuntimeError):
    """The controller raised, exited, hung or moved nothing.

    `scenario` are the lines of a scenario file that would give it what it waits for, if any;
    `code` is that of the run's end where this was a bad one (`RunEnd.code`).
    """

    exit_code = ExitCode.CONTROLLER_FAILED
    code = "no-command"

    def __init__(
        self,
        message: str,
        location: Location | None = None,
        scenario: str = "",
        code: str | None = None,
    ) -> None:
        super().__init__(message, location)
        self.scenario = scenario
        if code is not None:
            self.code = code


class LimitError(TraceRiskError, RuntimeError):
    """A limit of time or memory was reached before there was a result.

    It ends the command: what is not known in time must decide nothing.
    """

    exit_code = ExitCode.CONTROLLER_FAILED
    code = "limit"


class MachineError(LimitError):
    """The machine lacks disk or memory: what a run showed meanwhile is no result of the run."""

    code = "machine"


@contextlib.contextmanager
def readable(path: object, kind: type[InputError] = InputError) -> Iterator[None]:
    """Raise an error of this kind where a file cannot be read within."""
    try:
        yield
    except OSError as error:
        raise kind(f"cannot be read: {error.strerror}", Location(str(path))) from error


def interruption(error: BaseException) -> KeyboardInterrupt | SystemExit | None:
    """Return the Ctrl-C or the exit that caused an error, `None` where neither did.

    A library may turn one that comes during an import into an error of its own.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, KeyboardInterrupt | SystemExit):
        cause = cause.__cause__ or cause.__context__
    return cause


def disk_full(folder: str) -> MachineError:
    """Return the error of a full disk that holds a folder with temporary files."""
    return MachineError(
        f"the disk that holds {folder} is full, and so the run is not whole; free some of it, or "
        "name a folder on another one with TMPDIR, and run the same command again"
    )


def file_limited() -> MachineError:
    """Return the error of a limit of the shell to the size of files."""
    return MachineError(
        "a file may not grow as large here as the command needs it; raise the limit with "
        "`ulimit -f unlimited`, and run the same command again"
    )


def one_of(names: Iterable[str], found: str | None = None) -> str:
    """Return `allowed: a, b, c`, led by the nearest name to `found` where one is near.

    Of more than 100 names the first 50 stand there.
    """
    ordered = sorted(names)
    shown = ordered if len(ordered) <= 2 * _MOST_NAMES else ordered[:_MOST_NAMES]
    text = "allowed: " + (", ".join(shown) if shown else "none")
    if len(shown) < len(ordered):
        text += f" and {len(ordered) - len(shown):,} more"
    near = []
    if found is not None:
        from difflib import get_close_matches

        near = get_close_matches(found, ordered, n=1)
    return f"did you mean '{near[0]}'? {text}" if near else text
