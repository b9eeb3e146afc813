"""A source with the tracer's decorators, and the names in it."""

from __future__ import annotations

from dataclasses import dataclass

from tracerisk.errors import Location, UnsafeRewriteError

TRACER_MODULE = "__tracerisk__"
"""The module from which instrumented code imports its decorator; the loader serves it."""
DECORATOR = "__tracerisk_traced__"
"""The name of the decorator in instrumented code; not mangled in classes, hidden from `*`."""


@dataclass(frozen=True, slots=True)
class InstrumentedSource:
    """A source with the tracer's decorators."""

    file: str
    """The path from the controller's root, as in every `FunctionRef`."""
    original: bytes
    """The bytes on disk."""
    text: str
    """The instrumented source, decoded."""


def cannot_instrument(file: str, line: int | None) -> UnsafeRewriteError:
    """Return the error of a source that libcst reads in another way than Python."""
    return UnsafeRewriteError(
        "the source cannot be instrumented with proof that nothing else changes: libcst does not "
        "read it as Python does; rewrite this statement in a plainer way, or move it to a module "
        "that commands no motion",
        Location(file, line),
    )
