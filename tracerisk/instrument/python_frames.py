"""What Python's own frames show: which runs a function, and where in its source it is."""

from __future__ import annotations

from types import CodeType, FrameType

from tracerisk.common.function_ref import QualifiedName
from tracerisk.instrument.code_positions import qualified_name, source_position
from tracerisk.instrument.marks.call_log import Site
from tracerisk.instrument.source.function_definitions import MODULE

_COMPREHENSIONS = frozenset({"<listcomp>", "<setcomp>", "<dictcomp>", "<genexpr>"})
UNNAMED = _COMPREHENSIONS | {"<lambda>"}


def running_frame(
    candidate: FrameType | None, code: CodeType
) -> tuple[FrameType | None, FrameType | None]:
    """Find the innermost frame that runs `code`, and the comprehension it runs, if any.

    Up to Python 3.11 a comprehension is a frame of its own; it is part of its function.
    """
    inner: FrameType | None = None
    while candidate is not None and candidate.f_code is not code:
        inner, candidate = candidate, candidate.f_back
    if (
        candidate is not None
        and inner is not None
        and inner.f_code.co_name in _COMPREHENSIONS
        and inner.f_code.co_filename == code.co_filename
    ):
        return candidate, inner
    return candidate, None


def site_of(frame: FrameType) -> Site:
    """Return where in its source a frame is."""
    line, column = source_position(frame.f_code, frame.f_lasti)
    return (
        line or frame.f_lineno or frame.f_code.co_firstlineno,
        0 if column is None else column + 1,
    )


def enclosing_function(frame: FrameType) -> QualifiedName:
    """Return the function that a frame runs in: of a lambda or comprehension, that around it."""
    parts = qualified_name(frame.f_code, frame.f_globals).split(".<locals>.")
    while parts and parts[-1].startswith("<"):
        parts.pop()
    return QualifiedName(".<locals>.".join(parts)) if parts else MODULE
