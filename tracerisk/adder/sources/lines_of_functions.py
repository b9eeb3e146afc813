"""Which functions of a C or C++ source hold a line of it."""

from __future__ import annotations

from functools import cache

from tracerisk.adder.sources.c_source import CSource, parse_c
from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import SourceError
from tracerisk.instrument.source.language import is_c


def functions_at(file: str, line: int) -> list[QualifiedName]:
    """Return the functions that hold a line, the innermost last; none of a file that is not read.

    Raises:
        DependencyError: if the extra `cpp` is not installed.
    """
    source = _parsed(file)
    if source is None:
        return []
    return [
        function.name
        for function in source.functions
        if function.line <= line <= source.line_of(function.end - 1)
    ]


@cache
def _parsed(file: str) -> CSource | None:
    try:
        return parse_c(file_bytes(file), file) if is_c(file) else None
    except (OSError, SourceError):
        return None
