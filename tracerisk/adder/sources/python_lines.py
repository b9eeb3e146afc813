"""A Python source as lines of bytes and a tree, by the standard library alone.

Reading and removing blocks must be fast and needs no libcst; and what was inserted at libcst's
positions is checked against what this module finds.
`instrument/source/python_source.py` parses what is to run: it decodes and compiles the source and
says how to mend it, for which a check of blocks has no time. Here a source stays bytes, and a
conflict marker is an error of its blocks.
"""

from __future__ import annotations

import ast
import io
import re
import warnings
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.adder.blocks.conflicts import is_conflict_marker
from tracerisk.errors import BlockError, Location, SourceError
from tracerisk.instrument.source.function_definitions import Definition, first_line

if TYPE_CHECKING:
    from tokenize import TokenInfo

BYTE_ORDER_MARK = b"\xef\xbb\xbf"

# A header of one line without strings, comments or brackets that could continue on further lines.
_PLAIN_HEADER = rb"[ \t]*(?:async[ \t]+)?def[ \t][\w \t(),.=*:>-]*\)[\w \t.>-]*:"
_VERSION = re.compile(r"Python (2|3\.\d+)\b")  # what a source was written for
_CODING = rb"[ \t\f]*#.*?coding[:=][ \t]*[-\w.]+"


class Site(NamedTuple):
    """Where the block of a function goes."""

    line: int
    """The line before which it is inserted, from 1."""
    indent_line: int
    """The line whose indentation it takes."""


class PythonSource(NamedTuple):
    """A parsed Python source."""

    file: str
    """The path in messages."""
    lines: tuple[bytes, ...]
    """The lines as bytes, line ends kept."""
    encoding: str
    """The encoding of the file, such as `utf-8`."""
    tree: ast.Module
    """The syntax tree, which nobody may change."""
    converted: str | None = None
    """Of a source of Python 2, its conversion, which the tree is of: line for line; else `None`."""

    def text(self, number: int) -> str:
        """Return line `number` as text, without its line end.

        Raises:
            SourceError: if the line does not hold text in the file's encoding.
        """
        line = self.lines[number - 1].rstrip(b"\r\n")
        if number == 1:
            line = line.removeprefix(BYTE_ORDER_MARK)
        try:
            return line.decode(self.encoding)
        except UnicodeDecodeError as error:
            raise SourceError(
                f"the line is not {self.encoding} text: {error.reason}",
                Location(self.file, number),
            ) from error


@lru_cache(maxsize=2)  # of one source both functions and blocks are asked for
def parse_python(source: bytes, file: str) -> PythonSource:
    """Return the parsed source, whose tree nobody may change.

    Raises:
        BlockError: if what makes it unreadable is a conflict marker.
        SourceError: if it is not Python.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(source, file)
        encoding, converted = _encoding_of(source), None
    except SyntaxError as error:
        _forbid_conflict_markers(source, file)
        python_2 = _python_2(source, file)
        if python_2 is None:
            raise SourceError(
                f"cannot be read as Python: {error.msg}",
                Location(file, error.lineno, error.offset),
            ) from error
        encoding, converted, tree = python_2
    except (ValueError, RecursionError, MemoryError) as error:
        raise SourceError(f"cannot be read as Python: {error}", Location(file)) from error
    lines = tuple(source.splitlines(keepends=True))
    return PythonSource(file, lines, encoding, tree, converted)


def _python_2(source: bytes, file: str) -> tuple[str, str, ast.Module] | None:
    """Return encoding, conversion and tree of a source of Python 2; `None` where it is none.

    Where its names alone show Python 2, blocks need no conversion: Python 3 sees its functions too.

    Raises:
        SourceError: it cannot be converted, or is of a newer Python, with the place and the reason.
    """
    from tracerisk.instrument.source.python_source import parse_source

    try:
        read = parse_source(source, file)
    except SourceError as error:
        if error.location is not None and _VERSION.search(error.message):
            raise
        return None
    return _encoding_of(source), read.text, read.tree


def _encoding_of(source: bytes) -> str:
    """Return the encoding of a source that the parser takes; raise SyntaxError as it would."""
    if not any(b"coding" in line for line in source.split(b"\n", 2)[:2]):
        return "utf-8"
    from tokenize import detect_encoding

    encoding, _ = detect_encoding(io.BytesIO(source).readline)
    return "utf-8" if encoding == "utf-8-sig" else encoding


def _forbid_conflict_markers(source: bytes, file: str) -> None:
    for number, line in enumerate(source.splitlines(), start=1):
        text = line.decode("ascii", "replace")
        if is_conflict_marker(text):
            raise BlockError(
                f"`{text}` is a conflict marker; resolve the merge (keep either side of a risk "
                f"block: `tracerisk refresh {file}` makes it and a lock with conflicts anew), then "
                "run the same command again",
                Location(file, number),
            )


def module_line(source: PythonSource) -> int:
    """Return the line of the module's first statement; 1 where it has none."""
    return first_line(source.tree.body[0]) if source.tree.body else 1


def header_end(source: PythonSource, definition: Definition) -> int | None:
    """Return the line on which a function's header ends; `None` for a one-line function."""
    if definition.body_line == definition.line:
        return None
    header = source.lines[definition.line - 1].rstrip()
    if re.fullmatch(_PLAIN_HEADER, header) and header.count(b"(") == header.count(b")"):
        return definition.line
    import tokenize

    for token in _tokens_from(source, definition.line):
        if token.type == tokenize.NEWLINE:
            line = definition.line + token.start[0] - 1
            return line if line < definition.body_line else None
    return None


def _tokens_from(source: PythonSource, start: int) -> Iterator[TokenInfo]:
    from tokenize import generate_tokens

    numbers = iter(range(start, len(source.lines) + 1))
    converted = None if source.converted is None else source.converted.split("\n")

    def readline() -> str:
        number = next(numbers, None)
        if number is None:
            return ""
        return (source.text(number) if converted is None else converted[number - 1]) + "\n"

    return generate_tokens(readline)


def comment_lines(source: PythonSource) -> frozenset[int]:
    """Return the lines that hold a comment."""
    import tokenize

    numbers = set()
    try:
        for token in _tokens_from(source, 1):
            if token.type == tokenize.COMMENT:
                numbers.add(token.start[0])
    except (tokenize.TokenError, SyntaxError):
        # A source that the parser takes and the tokenizer does not (an odd dedent before a
        # form feed): what was found until there stands.
        pass
    return frozenset(numbers)


def preamble_end(source: PythonSource) -> int:
    """Return the last line of `#!` and encoding declaration; 0 where there is neither."""
    end = 0
    if source.lines and source.lines[0].removeprefix(BYTE_ORDER_MARK).startswith(b"#!"):
        end = 1
    for number, line in enumerate(source.lines[:2], start=1):
        content = line.removeprefix(BYTE_ORDER_MARK) if number == 1 else line
        if re.match(_CODING, content):
            return number
        if number == 1 and content.strip() and not content.lstrip(b" \t\f").startswith(b"#"):
            break
    return end


def docstring_end(source: PythonSource) -> int | None:
    """Return the last line of the module's docstring, where it has its lines to itself."""
    body = source.tree.body
    if not body or not isinstance(body[0], ast.Expr):
        return None
    value = body[0].value
    if not isinstance(value, ast.Constant) or not isinstance(value.value, str):
        return None
    end = value.end_lineno
    if end is None or (len(body) > 1 and first_line(body[1]) <= end):
        return None
    return end
