"""Read a Python source file: its encoding, its syntax tree, and why it cannot be read.

A source of Python 2 is read too: by its conversion to Python 3 in memory.
"""

from __future__ import annotations

import ast
import contextlib
import io
import re
import sys
import tokenize
import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import DependencyError, Location, SourceError
from tracerisk.instrument.source.function_definitions import definitions
from tracerisk.instrument.source.python_2 import (
    NotConvertibleError,
    bare_clauses,
    binds_in_bare_clauses,
    catches_in_bare_clauses,
    is_caught,
    is_only_python_3,
    may_be_python_2,
    shows_python_2,
)

_BARE_CLAUSE = "multiple exception types must be parenthesized"
_TOO_DEEP = "too many nested parentheses"  # 200 levels; Python 2 reads 100 at most
_NEWER_LINES = (
    ((3, 14), re.compile(r"(?<![\w'\"])([tT][rR]?|[rR][tT])['\"]")),
    ((3, 13), re.compile(r"^\s*((async\s+)?def|class|type)\s+\w+\s*\[[^\]=]*=")),
    ((3, 12), re.compile(r"^\s*((async\s+)?def|class)\s+\w+\s*\[|^\s*type\s+\w+\s*[\[=]")),
)
_PYTHON_2_REASONS = (
    "Missing parentheses in call to 'print'",
    "Missing parentheses in call to 'exec'",
    _BARE_CLAUSE,
    "leading zeros in decimal integer literals",
)
_PYTHON_2_LINES = tuple(
    re.compile(pattern)
    for pattern in (
        r"^\s*(print|exec)\s+[^\s(=.,:\[]",
        r"^\s*print\s*>>",
        r"^\s*raise\s+[\w.]+\s*,",
        r"^\s*except\s+[\w.()\s,]+,\s*\w+\s*:",
        r"<>",
        r"`[^`]+`",
        r"\b[uU][rR]['\"]",
        r"\b(0[xX][0-9a-fA-F]+|\d+)[lL]\b",
        r"\b0\d+\b",
        r"^\s*def\s+\w+\s*\(.*\([\w\s,]+\).*\)\s*:",
        r"\blambda\s*\(",
    )
)


@dataclass(frozen=True, slots=True)
class FunctionSite:
    """A function of a source file and the place of its definition."""

    ref: FunctionRef
    """The file and qualified name of the function."""
    line: int
    """The line of its `def`, from 1; 1 for `<module>`."""


@dataclass(frozen=True, slots=True, eq=False)
class ParsedSource:
    """A source file that Python 3 compiles, as it is or converted."""

    file: str
    """The path from the controller's root."""
    text: str
    """The decoded source without its byte order mark, line ends unchanged; of a source of Python 2,
    its conversion to the syntax of Python 3, in which each line stands for the same line."""
    tree: ast.Module
    """The syntax tree of the text."""
    functions: tuple[FunctionSite, ...]
    """Every `def` and `async def` in the order of the file; no two share a line, so the n-th that
    another parser meets is the n-th here."""
    is_python_2: bool = False
    """Whether the source is Python 2: the tree has to run with the meaning that it has there."""


def parse_source(source: bytes, file: str) -> ParsedSource:
    """Decode (PEP 263) and parse a source file; `file` is what errors call it.

    Raises:
        SourceError: the bytes are not in the encoding they claim, or neither Python 3 nor
            convertible from Python 2.
    """
    text = _decode(source, file)
    try:
        read = read_python(text, file)
        # Some errors (`return` outside a function) show only when the symbols are resolved.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(read.tree, file, "exec", dont_inherit=True)
    except SyntaxError as error:
        raise _source_error(error, text, file) from error
    except ValueError as error:
        raise SourceError(f"this is not a Python source: {error}", Location(file)) from error
    except RecursionError as error:
        raise SourceError("the source nests too deeply to be parsed", Location(file)) from error
    return ParsedSource(file, read.text, read.tree, _functions(read.tree, file), read.is_python_2)


class ReadPython(NamedTuple):
    """A source as Python 3 reads it."""

    text: str
    """The source, or its conversion from Python 2."""
    tree: ast.Module
    """The syntax tree of the text."""
    is_python_2: bool
    """Whether the text was converted."""


def read_python(text: str, file: str = "<unknown>") -> ReadPython:
    """Read a decoded source; `file` is what errors call it.

    It is Python 2 if Python 3 cannot parse it but can parse its conversion, or if it uses names or
    states an interpreter that only Python 2 has, and Python 2 can read it. Which of both a clause
    like `except ValueError, name:` means depends on the name, not on the Python that runs this.

    Raises:
        SyntaxError: it is neither; for what seems to be Python 2, the cause is the
            NotConvertibleError that says why it cannot be converted.
        ValueError, RecursionError: as `ast.parse`.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            tree = ast.parse(text, file)
        except SyntaxError as error:
            if error.msg == _TOO_DEEP or (
                error.msg == _BARE_CLAUSE and catches_in_bare_clauses(text)
            ):
                raise
            try:
                read = _read_python_2(text, file)
            except NotConvertibleError as reason:
                raise error from reason
            except DependencyError:
                if _seems_python_2(error, _shown_line(error, text)):
                    raise
                raise error from None
            if is_only_python_3(read.tree):
                raise
            return read
        shows = (may_be_python_2(text) and shows_python_2(tree, text)) or binds_in_bare_clauses(
            text, tree
        )
        if shows and not is_only_python_3(tree):
            with contextlib.suppress(NotConvertibleError):
                return _read_python_2(text, file)
    return ReadPython(text, tree, is_python_2=False)


def _read_python_2(text: str, file: str) -> ReadPython:
    from tracerisk.instrument.source.python_2_text import converted

    plain = converted(text)
    try:
        return ReadPython(plain, ast.parse(plain, file), is_python_2=True)
    except SyntaxError as error:
        raise NotConvertibleError(f"{error.msg} in the conversion", error.lineno) from None


@lru_cache(maxsize=256)
def is_python_2(source: bytes) -> bool:
    """Return whether a source can be read, and is read as Python 2."""
    try:
        return read_python(decoded(source)).is_python_2
    except (SyntaxError, ValueError, RecursionError):
        return False


def _functions(tree: ast.Module, file: str) -> tuple[FunctionSite, ...]:
    sites = [
        FunctionSite(FunctionRef(file, definition.name), definition.line)
        for definition in definitions(tree)
    ]
    return tuple(sorted(sites, key=lambda site: site.line))


def _decode(source: bytes, file: str) -> str:
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(source).readline)
    except SyntaxError as error:
        raise SourceError(
            f"{error.msg}; name one that Python knows in the first two lines (PEP 263), "
            "e.g. `# -*- coding: utf-8 -*-`",
            Location(file, 1),
        ) from error
    try:
        return source.decode(encoding)
    except LookupError as error:
        raise SourceError(f"{error}; save the file as UTF-8", Location(file, 1)) from error
    except UnicodeDecodeError as error:
        before = source[: error.start]
        line_start = max(before.rfind(b"\n"), before.rfind(b"\r")) + 1
        line = before.replace(b"\r\n", b"\n").replace(b"\r", b"\n").count(b"\n") + 1
        raise SourceError(
            f"byte 0x{source[error.start]:02x} is not {encoding}: save the file as UTF-8, or "
            "name its encoding in the first two lines (PEP 263), "
            "e.g. `# -*- coding: latin-1 -*-`",
            Location(file, line, error.start - line_start + 1),
        ) from error


def _source_error(error: SyntaxError, text: str, file: str) -> SourceError:
    shown = _shown_line(error, text)
    message = f"not valid Python: {error.msg}" + (f" in `{shown}`" if shown else "")
    reason = error.__cause__
    if (newer := _newer_python(error, shown, text)) is not None:
        message += (
            f"; Python {newer} accepts it if nothing else is wrong, but this is "
            f"{sys.version_info[0]}.{sys.version_info[1]}: install tracerisk under Python {newer}"
        )
        if error.msg == _BARE_CLAUSE:
            message += ", or write parentheses; of Python 2, let the first line name `python2`"
    elif isinstance(reason, NotConvertibleError) and _seems_python_2(error, shown):
        where = f" at line {reason.line}" if reason.line else ""
        message = (
            f"this is Python 2: `{shown}` is not valid in Python 3 ({error.msg}), and the file "
            f"cannot be converted in memory{where}: {reason.reason}; mend that, or convert the "
            "file first, e.g. with `2to3 -w` or `python-modernize -w`"
        )
    return SourceError(message, Location(file, error.lineno, error.offset or None))


def _newer_python(error: SyntaxError, shown: str, text: str) -> str | None:
    """Return the first Python that accepts the shown line, if it is newer than this one."""
    needed = next((version for version, line in _NEWER_LINES if line.search(shown)), (3, 0))
    if "f-string" in (error.msg or ""):
        needed = max(needed, (3, 12))
    elif error.msg == _BARE_CLAUSE:
        clauses = [clause for clause in bare_clauses(text) if clause.begin[0] == error.lineno]
        is_newer = clauses and is_caught(clauses[0], None)
        needed = (3, 14) if is_newer or catches_in_bare_clauses(text) else needed
    return f"{needed[0]}.{needed[1]}" if sys.version_info < needed else None


def _shown_line(error: SyntaxError, text: str) -> str:
    lines = text.splitlines()
    shown = error.text
    if shown is None and error.lineno is not None and 0 < error.lineno <= len(lines):
        shown = lines[error.lineno - 1]
    return (shown or "").strip()


def _seems_python_2(error: SyntaxError, shown: str) -> bool:
    if any(error.msg.startswith(reason) for reason in _PYTHON_2_REASONS):
        return True
    if isinstance(error, TabError):
        return True
    return any(pattern.search(shown) for pattern in _PYTHON_2_LINES)


def parsed(source: bytes | str) -> ast.Module | None:
    """Return the tree of a source, a new one each time; `None` where it cannot be parsed."""
    try:
        text = source if isinstance(source, str) else _decode(source, "")
        return read_python(text).tree
    except (SourceError, SyntaxError, ValueError, RecursionError):
        return None


def texts_in(tree: ast.AST) -> list[str]:
    """Return the strings of a source, breadth first."""
    return [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]


def decoded(source: bytes) -> str:
    """Return the text of a source, by the encoding that it states."""
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(source).readline)
        return source.decode(encoding)
    except (SyntaxError, UnicodeDecodeError, LookupError):
        return source.decode("utf-8", errors="replace")
