"""What git leaves in a file where a merge failed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal

_MARKER = r"(<{7}|>{7}|\|{7})( .*)?|={7}"
_ANY_MARK = rb"(?:^|[\r\n])(?:<{7}|>{7}|={7}|\|{7})"
_AFTER_MARK: Mapping[str, Literal["both", "ours", "base", "theirs"]] = {
    "<": "ours",
    "|": "base",
    "=": "theirs",
    ">": "both",
}


def is_conflict_marker(text: str) -> bool:
    """Return whether a line is one of those that git leaves where a merge failed."""
    return re.fullmatch(_MARKER, text.rstrip()) is not None


def conflict_sides(data: bytes) -> tuple[int, bytes, bytes] | None:
    """Return the first conflict's line and the file as each side has it; `None` without one."""
    if not any(7 * mark in data for mark in (b"<", b">", b"=", b"|")):
        return None  # as in nearly every file, for which no expression need be compiled
    if re.search(_ANY_MARK, data) is None:
        return None
    sides: tuple[list[bytes], list[bytes]] = ([], [])
    within: Literal["both", "ours", "base", "theirs"] = "both"
    first = None
    for number, line in enumerate(data.splitlines(keepends=True), start=1):
        mark = line.rstrip().decode(errors="replace")
        if is_conflict_marker(mark):
            first = first or number
            within = _AFTER_MARK[mark[0]]
            continue
        if within in ("both", "ours"):
            sides[0].append(line)
        if within in ("both", "theirs"):
            sides[1].append(line)
    return None if first is None else (first, b"".join(sides[0]), b"".join(sides[1]))
