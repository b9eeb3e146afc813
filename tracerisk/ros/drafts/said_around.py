"""What a source says where it asks for something: its comments, docstrings and code."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from tracerisk.common.text.bounded import file_text
from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.literals.called_functions import calls_at, source_tree

_RANGE = re.compile(r"(?<![\w.])0(?:\.0*)?\s*(?:-|~|\.\.|,|to)\s*(\d+(?:\.\d*)?)(?![\w.]*\d)")
_OPEN_AT_0 = re.compile(r"(?<![\w.])0(?:\.0*)?\s*[:=(]?\s*(?:is|means)?\s*(?:fully )?open")
_FURTHER = 3  # lines on which an answer is taken apart


def lines_with(text: str, name: str) -> str:
    """Return the lines of a source that name something, with their comments."""
    named = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)")
    return "\n".join(line for line in text.splitlines() if named.search(line))


def said_of_name(place: Location | None, name: str) -> str:
    """Return the lines that name something in the source of a place."""
    return lines_with("\n".join(_lines(place)), name)


def ranges_said(place: Location | None) -> dict[str, tuple[float, bool]]:
    """Return the largest number of what has a range from 0 in a comment of the source, by name.

    `self.position = position  # 0-1000` gives `position: (1000.0, False)`; the truth value is
    whether the same line says that 0 is open.
    """
    ranges: dict[str, tuple[float, bool]] = {}
    for line in _lines(place):
        code, _, comment = line.partition("#")
        match = _RANGE.search(comment)
        if match is None or float(match[1]) <= 0.0:
            continue
        is_open = _OPEN_AT_0.search(comment.lower()) is not None
        for name in re.findall(r"[A-Za-z_]\w*", code):
            ranges.setdefault(name, (float(match[1]), is_open))
    return ranges


def said_at(place: Location | None) -> str:
    """Return the line of a place with those behind it."""
    if place is None or place.line is None:
        return ""
    return "\n".join(_lines(place)[place.line - 1 : place.line + _FURTHER])


def said_in_callback(place: Location | None) -> str:
    """Return the functions that a call at a place names, with their comments; empty for none."""
    tree = source_tree(place)
    if tree is None or place is None:
        return ""
    lines = _lines(place)
    named = set(_named_at(tree, place.line))
    return "\n".join(
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name in named
        for line in lines[node.lineno - 1 : node.end_lineno]
    )


def _named_at(tree: ast.Module, line: int | None) -> Iterator[str]:
    for call in calls_at(tree, line):
        for value in (*call.args, *(keyword.value for keyword in call.keywords)):
            yield from (last_name(node) for node in ast.walk(value))


def _lines(place: Location | None) -> list[str]:
    if place is None:
        return []
    try:
        return file_text(Path(place.file), errors="replace").splitlines()
    except (OSError, ValueError):
        return []
