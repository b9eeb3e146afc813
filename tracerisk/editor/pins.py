"""Edits of a block's values: set by hand with a reason, or put back as the tool wrote them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.adder.blocks.values import NEXT
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.editor.hover import component_at

_VALUE = re.compile(
    r"(?P<before>\s*(?:#\s?\||\*)\s+)(?P<key>callSequence|next|probability|quantity|redundancy)"
    r"\s*(?P<operator>:?=)\s*(?P<value>[^!]*?)\s*(?:!\s*(?P<comment>.*?)\s*)?"
)


@dataclass(frozen=True, slots=True)
class ValueLine:
    """One `key = value` line of a block."""

    line: int
    """The number of the line, from 0."""
    before: str
    """The indentation and comment sign before the key."""
    key: str
    """The key, such as `probability`."""
    is_pinned: bool
    """Whether the value is set by hand (`:=`)."""
    value: str
    """The value as it is written."""
    comment: str | None
    """The text behind `!`; `None` where there is none."""

    def pinned(self, comment: str) -> str:
        """Return the line with its value set by hand."""
        return f"{self.before}{self.key} := {self.value}" + (f" ! {comment}" if comment else "")

    def with_value(self, value: str) -> str:
        """Return the line with another value, which is the tool's."""
        return f"{self.before}{self.key} = {value}"


def value_line(texts: Sequence[str], line: int) -> ValueLine | None:
    """Return the value that a line states, from 0; `None` where it states none."""
    matched = _VALUE.fullmatch(texts[line]) if 0 <= line < len(texts) else None
    if matched is None:
        return None
    return ValueLine(
        line,
        matched["before"],
        matched["key"],
        matched["operator"] == ":=",
        matched["value"],
        matched["comment"],
    )


def written_value(block: PlacedBlock, base: WrittenBlock | None, value: ValueLine) -> str | None:
    """Return the text that the lock says was written for a value; `None` where it has none."""
    if base is None:
        return None
    if value.key in base.values:
        return base.values[value.key]
    component = component_at(block, value.line + 1)
    kept = None if component is None else base.components.get(component.name)
    return None if kept is None else kept.values.get(value.key)


def pinning(
    texts: Sequence[str], block: PlacedBlock, line: int, computed: str | None, reason: str
) -> dict[int, str]:
    """Return the lines, by number from 0, with which a value is set by hand for a reason.

    `computed` is what the tool would write, where that is known. Without a reason its place is
    left for one. Empty where the line states no value, or one that has a reason already.
    """
    at = value_line(texts, line)
    if at is None:
        return {}
    reason = " ".join(reason.replace("!", ".").split())
    if at.is_pinned:
        return _with_reason(texts, at, reason)
    value_lines = [at]
    if at.key == NEXT.key:
        # All of its lines are one value, and the last has the reason.
        numbers = range(block.first_line - 1, min(block.last_line, len(texts)))
        values = [value_line(texts, number) for number in numbers]
        value_lines = [value for value in values if value is not None and value.key == NEXT.key]
    comment = reason if computed is None else f"computed {computed}; {reason}"
    edits = {item.line: item.pinned("") for item in value_lines}
    edits[value_lines[-1].line] = value_lines[-1].pinned(comment)
    return edits


def _with_reason(texts: Sequence[str], at: ValueLine, reason: str) -> dict[int, str]:
    following = texts[at.line + 1].lstrip() if at.line + 1 < len(texts) else ""
    goes_on = re.match(r"(?:#\s?\||\*)\s+!", following) is not None
    computed, _, kept = (at.comment or "").partition(";")
    has_computed = computed.startswith("computed ")
    if goes_on or kept.strip() or (at.comment and not has_computed):
        return {}
    return {at.line: at.pinned(f"{computed}; {reason}" if has_computed else reason)}
