"""Report what a ROS library raised and the controller caught: a run that goes on hides it.

Each `except` clause of the controller reports what it caught, and `contextlib.suppress` what it
suppressed. Reported is a call that could never succeed (an unknown group, a wrong type), not one
that may be tried again: a timeout, a transform that is not there yet, a shutdown.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

import tracerisk
from tracerisk.common.replaced_names import replaced
from tracerisk.common.traced.findings import Finding
from tracerisk.errors import Location
from tracerisk.instrument.code_positions import source_position
from tracerisk.instrument.marks.call_log import Calls
from tracerisk.instrument.marks.calls import MarkedCall, marked_calls
from tracerisk.instrument.marks.endless_loops import begin_with_call, import_into
from tracerisk.instrument.marks.tried_again import is_tried_until_success
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.python_source import parsed
from tracerisk.trace import RunEnd

CAUGHT = "__tracerisk_caught__"
"""The name of the report in instrumented code; not mangled in classes, hidden from `*`."""

STAND_INS = (f"{Path(tracerisk.__file__).parent}/ros/",)
"""Where the code of the ROS libraries lies that a controller calls on the stand-ins."""
QUESTIONS = frozenset({"ament_index_python", "rospkg"})
"""The libraries that are asked whether a package is installed: an exception is their answer."""
_QUESTIONS = tuple(f"{STAND_INS[0]}stand_ins/{library}/" for library in QUESTIONS)
# Of these exactly: what is derived from them has a meaning of its own.
_MISUSE = frozenset(
    {"RuntimeError", "TypeError", "ValueError", "AssertionError", "IndexError"}
    | {"MoveItCommanderException", "ROSSerializationException", "SerializationError"}
    | {"MessageException", "InvalidTopicNameException", "InvalidServiceNameException"}
)


REFUSED = "call_raised"
"""The kind of the finding of a call that a stand-in refused by an exception which was caught."""


@dataclass(frozen=True, slots=True)
class CaughtFailure:
    """An exception by which a ROS library refused a call."""

    location: Location
    """The controller's line."""
    call: str
    """What was called: the name of a function, or of a class."""
    message: str
    """The type of the exception and its text, on one line."""

    @property
    def words(self) -> str:
        """What happened, in a sentence."""
        return f"the controller went on although {self.call} raised {self.message}"


def mark_handlers(tree: ast.Module, module: str) -> None:
    """Insert the report, imported from `module`, at the beginning of each `except` clause."""
    handlers = [node for node in ast.walk(tree) if isinstance(node, ast.ExceptHandler)]
    for handler in handlers:
        begin_with_call(handler.body, CAUGHT)
    import_into(tree, module, {"caught": CAUGHT} if handlers else {})


def caught_failure(
    error: BaseException, files: Mapping[str, str], libraries: tuple[str, ...] = STAND_INS
) -> CaughtFailure | None:
    """Return the call that a ROS library refused by an exception, `None` for any other exception.

    `files` are the controller's files by the names that code objects have for them, `libraries`
    the folders of the ROS libraries.
    """
    if type(error).__name__ not in _MISUSE:
        return None
    entries = list(_entries(error.__traceback__))
    own = [at for at, entry in enumerate(entries) if entry.tb_frame.f_code.co_filename in files]
    if not own:
        return None
    last = entries[own[-1]]
    refused = [
        entry.tb_frame
        for entry in entries[own[-1] + 1 :]
        if entry.tb_frame.f_code.co_filename.startswith(libraries)
    ]
    if not refused or refused[0].f_code.co_filename.startswith(_QUESTIONS):
        return None
    code = last.tb_frame.f_code
    _, column = source_position(code, last.tb_lasti)
    call = refused[0].f_code.co_name
    if call.startswith("__") and "self" in refused[0].f_locals:
        call = type(refused[0].f_locals["self"]).__name__
    place = Location(
        files[code.co_filename], last.tb_lineno, None if column is None else column + 1
    )
    text = " ".join(str(error).split())
    return CaughtFailure(
        place, call, f"{type(error).__name__}: {text}" if text else type(error).__name__
    )


@contextlib.contextmanager
def suppressed_reported(report: Callable[[BaseException], None]) -> Iterator[None]:
    """Report what `contextlib.suppress` suppresses, until closed."""
    real = contextlib.suppress.__exit__

    def leave(
        self: contextlib.suppress,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> bool:
        is_over = real(self, kind, error, trace)
        if is_over and error is not None:
            report(error)
        return is_over

    with replaced([(contextlib.suppress, "__exit__", leave)]):
        yield


def _entries(entry: TracebackType | None) -> Iterator[TracebackType]:
    while entry is not None:
        yield entry
        entry = entry.tb_next


# Which of them are settled


def with_settled_refusals(
    findings: Sequence[Finding], calls: Calls | None, end: RunEnd, source_of: Callable[[str], bytes]
) -> tuple[Finding, ...]:
    """Return the findings, with those of refused calls that need no report marked as recovered.

    That is so where a loop tried a call until it succeeded (`is_tried_until_success`), where an
    `except` clause made the same call with success (with another group name), and where another
    finding or the end of the run has the same line.
    """
    told = {_line(finding.location) for finding in findings if finding.kind != REFUSED}
    if not end.is_good:
        told.add(_line(end.location))
    return tuple(
        replace(finding, recovered_s=finding.time_s)
        if finding.kind == REFUSED
        and (_line(finding.location) in told or _has_another_way(finding, calls, source_of))
        else finding
        for finding in findings
    )


def _line(place: Location | None) -> tuple[str, int | None] | None:
    return None if place is None else (place.file, place.line)


def _has_another_way(
    finding: Finding, calls: Calls | None, source_of: Callable[[str], bytes]
) -> bool:
    place = finding.location
    if calls is None or place is None or place.line is None or place.column is None:
        return False
    tree = parsed(source_of(place.file))
    if tree is None:
        return False
    site = (place.line, place.column)
    marked = {id(call.node): call for call in marked_calls(tree)}

    def calls_in(*nodes: ast.AST) -> list[MarkedCall]:
        inner = (part for node in nodes for part in ast.walk(node))
        return [marked[id(node)] for node in inner if id(node) in marked]

    succeeded = {at for file, at in calls.executed - calls.raised if file == place.file}
    if site in succeeded and any(
        is_tried_until_success(tree, call.node) for call in marked.values() if call.site == site
    ):
        return True
    for node in ast.walk(tree):
        if isinstance(node, ast.Try):
            refused = [call for call in calls_in(*node.body) if call.site == site]
            names = {last_name(call.node.func) for call in refused}
            others = calls_in(*node.handlers)
            if any(last_name(c.node.func) in names and c.site in succeeded for c in others):
                return True
    return False
