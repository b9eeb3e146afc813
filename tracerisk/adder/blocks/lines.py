"""The lines of a block in either form: gutter and width, values with whose they are, reasons."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import Field
from tracerisk.adder.blocks.conflicts import is_conflict_marker
from tracerisk.adder.blocks.values import NOTHING_COMPUTED, FieldKind
from tracerisk.errors import BlockError, Location

GUTTER = "# | "
HEADER = "RiskAnnotation"

DEFAULT_WIDTH = 79
"""The width that printed lines keep to, the indentation included, where words allow it."""
FURTHER = "    "
"""What a line begins with that goes on with the one before."""
_NARROWEST, _TAB_COLUMNS = 40, 8
_LETTER = r"[^\W\d]"


class BlockLine(NamedTuple):
    """One line of a block."""

    number: int
    """The number of the line in the file, from 1."""
    text: str
    """The text after the gutter."""


class ValueText(NamedTuple):
    """A value as a block states it."""

    text: str
    """The value as it is written."""
    pinned: bool
    """Whether it stands behind `:=`."""
    comment: list[str]
    """The comment after `!`, line by line."""
    location: Location
    """The file and line."""


def forbid_conflict_marker(line: BlockLine, file: str) -> None:
    """Raise BlockError where a line is one that git leaves where a merge failed."""
    text = line.text.strip()
    if text and text[0] in "<>=|" and is_conflict_marker(text):
        raise BlockError(
            f"`{text}` is a conflict marker in a risk block; resolve the merge (keep either side "
            "of the block: a refresh computes it anew), then run the same command again",
            Location(file, line.number),
        )


def read_field(kind: FieldKind, stated: ValueText) -> Field[Any]:
    """Return the field that a value with its comment makes.

    Raises:
        BlockError: if the value, or the one behind `computed`, is not allowed.
    """
    joined = joined_comment(stated.comment)
    computed, reason = _split_comment(joined)
    if computed is not None and computed != NOTHING_COMPUTED:
        if re.match(_LETTER, computed) and not _is_readable(kind, computed):
            # A reason that begins with this word.
            computed, reason = None, joined
        else:
            _value(kind, stated, computed, "! computed ")
    return Field(
        value=_value(kind, stated, stated.text, "= "),
        text=stated.text,
        pinned=stated.pinned,
        computed=computed,
        reason=reason,
        location=stated.location,
        comment_lines=tuple(stated.comment),
    )


def _value(kind: FieldKind, stated: ValueText, text: str, before: str) -> Any:
    try:
        return kind.read(text)
    except ValueError as error:
        message = f"{kind.key} {before}{text} is not allowed; allowed: {error}"
        for mark in "#;":
            value, _, reason = text.partition(mark)
            if reason and _is_readable(kind, value.strip()):
                words = f"{kind.key} := {value.strip()}  ! {reason.strip()}"
                message = f"put a reason after `!`, not after `{mark}`; write `{words}`"
        if before.startswith("!"):
            value, _, reason = text.partition(" ")
            if reason and _is_readable(kind, value):
                message = f"write `;` before the reason: `{before}{value}; {reason}`"
        raise BlockError(message, stated.location) from error


def _is_readable(kind: FieldKind, text: str) -> bool:
    try:
        kind.read(text)
    except ValueError:
        return False
    return True


def joined_comment(comment: list[str]) -> str | None:
    """Return the parts of a comment as one text in single spaces; `None` for nothing."""
    return " ".join(" ".join(comment).split()) or None if comment else None


def _split_comment(comment: str | None) -> tuple[str | None, str | None]:
    """Return what a comment says was computed, and the reason it gives."""
    if comment is None:
        return None, None
    if comment.startswith("computed "):
        # Users put a reason behind a further `!`; the tool writes `;`.
        computed, *reason = re.split("[;!]", comment.removeprefix("computed "), maxsplit=1)
        return computed.strip(), "".join(reason).strip() or None
    return None, comment.removeprefix(";").strip() or None


def comment_text(computed: str | None, reason: str | None) -> str | None:
    """Return the comment that `_split_comment` splits into the same two parts."""
    if computed is not None:
        return f"computed {computed}; {reason}" if reason else f"computed {computed}"
    if reason is not None and reason.startswith(("computed ", ";")):
        return f"; {reason}"
    return reason


def width_behind(indent: bytes) -> int:
    """Return how wide the lines of a block may be after an indentation."""
    return max(_NARROWEST, DEFAULT_WIDTH - len(indent.expandtabs(_TAB_COLUMNS)))


def wrapped(lead: str, items: Sequence[str], further: str, width: int) -> list[str]:
    """Return `items` in a list behind `lead`, wrapped onto lines that begin with `further`.

    A line that goes on ends with a comma.
    """
    room = width - len(GUTTER)
    lines = [lead + items[0]]
    for item in items[1:]:
        if len(lines[-1]) + len(f", {item},") > room:
            lines[-1] += ","
            lines.append(further + item)
        else:
            lines[-1] += f", {item}"
    return lines


def field_with_comment(line: str, value: Field[Any], width: int) -> list[str]:
    """Return the line of a value with its comment, as `with_comment`."""
    comment = comment_text(value.computed, value.reason)
    return with_comment(line, comment, width, value.comment_lines)


def with_comment(
    line: str, comment: str | None, width: int, typed: Sequence[str] = ()
) -> list[str]:
    """Return `line` with its comment, wrapped onto lines of its own where the room ends.

    Where the comment is still the one that was `typed`, its lines end where they did.
    """
    if comment is None:
        return [line]
    if comment == joined_comment([*typed]):
        first, *others = typed
        begin = f"{line}  ! {first}" if first else line
        return [begin, *(f"    ! {text}".rstrip() for text in others)]
    room = width - len(GUTTER)
    lines, mark = [line], "  !"
    for word in comment.split(" "):
        if len(lines[-1]) + len(mark) + 1 + len(word) > room:
            lines.append(f"{FURTHER}!")
            mark = ""
        lines[-1] += f"{mark} {word}"
        mark = ""
    return lines
