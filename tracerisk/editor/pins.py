"""Edits of a block's values: set by hand with a reason, or put back as the tool wrote them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.adder.blocks.grammar import print_block
from tracerisk.adder.blocks.lines import DEFAULT_WIDTH, GUTTER, HEADER
from tracerisk.adder.blocks.values import NEXT, FieldKind, block_fields
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.editor.hover import component_at

_VALUE = re.compile(
    r"(?P<before>\s*(?:#\s?\||\*)\s+)(?P<key>callSequence|next|probability|quantity|redundancy)"
    r"\s*(?P<operator>:?=)\s*(?P<value>[^!]*?)\s*(?:!\s*(?P<comment>.*?)\s*)?"
)


_FIRST_OF_FUNCTION = ("next", "callSequence")


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

    def with_value(self, value: str) -> dict[int, str]:
        """Return the line, by its number from 0, with another value, which is the tool's."""
        return {self.line: f"{self.before}{self.key} = {value}"}


@dataclass(frozen=True, slots=True)
class CompactValue:
    """One value of a block in the compact form."""

    texts: Sequence[str]
    """The lines of the source."""
    placed: PlacedBlock
    """The block."""
    component: str | None
    """The component whose value it is; `None` for one of the function."""
    kind: FieldKind
    """The kind of the value."""
    field: Field[Any]
    """The value as the block states it."""

    @property
    def key(self) -> str:
        """The key, such as `probability`."""
        return self.kind.key

    @property
    def is_pinned(self) -> bool:
        """Whether the value is set by hand."""
        return self.field.pinned

    def with_value(self, text: str) -> dict[int, str]:
        """Return the lines, from 0, with another value, which is the tool's."""
        return self._edits(Field(self.kind.read(text), text))

    def pinned(self, computed: str | None, reason: str) -> dict[int, str]:
        """Return the lines, from 0, with the value set by hand; none where it has a reason."""
        if self.field.pinned and self.field.reason:
            return {}
        known = self.field.computed if self.field.pinned else computed
        return self._edits(replace(self.field, pinned=True, computed=known, reason=reason or None))

    def _edits(self, field: Field[Any]) -> dict[int, str]:
        """Return the lines of the block that differ with another value in it."""
        first, last = self.placed.first_line - 1, self.placed.last_line - 1
        if self.texts[last].strip().endswith("*/"):
            last -= 1
        while HEADER not in self.texts[first]:
            first += 1
        prefix = self.texts[first].partition(HEADER)[0]
        width = max(40, DEFAULT_WIDTH - len(prefix.expandtabs(8)) + len(GUTTER))
        block = _with_field(self.placed.block, self.component, self.kind, field)
        printed = [prefix + line.removeprefix(GUTTER) for line in print_block(block, width)]
        old = last - first + 1
        # A reason may take lines of its own: they are put behind the last one.
        rows = [*printed[: old - 1], "\n".join(printed[old - 1 :])]
        rows += [""] * (old - len(rows))
        pairs = enumerate(zip(rows, self.texts[first : last + 1], strict=True), start=first)
        return {number: row for number, (row, text) in pairs if row != text}


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


def value_at(
    texts: Sequence[str], block: PlacedBlock | None, line: int, key: str = ""
) -> ValueLine | CompactValue | None:
    """Return the value that a line of a block states, from 0, in either form.

    A line of the compact form states several: `key` says which one is meant.
    """
    if block is not None and block.block.form == "compact":
        return _compact_value(texts, block, line, key)
    return value_line(texts, line)


def written_value(block: PlacedBlock, base: WrittenBlock | None, key: str, line: int) -> str | None:
    """Return the text that the lock says was written for a value; `None` where it has none."""
    if base is None:
        return None
    if key in base.values:
        return base.values[key]
    component = component_at(block, line + 1)
    kept = None if component is None else base.components.get(component.name)
    return None if kept is None else kept.values.get(key)


def pinning(
    texts: Sequence[str], block: PlacedBlock, line: int, computed: str | None, reason: str
) -> dict[int, str]:
    """Return the lines, by number from 0, with which a value is set by hand for a reason.

    `computed` is what the tool would write, where that is known. Without a reason its place is
    left for one. Empty where the line states no value, or one that has a reason already.
    """
    reason = " ".join(reason.replace("!", ".").split())
    at = value_at(texts, block, line)
    if isinstance(at, CompactValue):
        return at.pinned(computed, reason)
    if at is None:
        return {}
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


def _compact_value(
    texts: Sequence[str], placed: PlacedBlock, line: int, key: str = ""
) -> CompactValue | None:
    """Return a value that a line states, from 0: that of a key, else the one that matters most.

    That is the probability of a component, and what follows a function. `None` for no value.
    """
    if placed.block.form != "compact" or HEADER in texts[line]:
        return None
    component = component_at(placed, line + 1)
    name = None if component is None else component.name
    fields = block_fields(placed.block, name)
    wanted = [key] if key else ["probability"] if name is not None else _FIRST_OF_FUNCTION
    for candidate in wanted:
        if candidate in fields:
            return CompactValue(texts, placed, name, *fields[candidate])
    return None


def _with_field(
    block: RiskBlock, component: str | None, kind: FieldKind, field: Field[Any]
) -> RiskBlock:
    names = {"callSequence": "call_sequence"}
    change: dict[str, Any] = {names.get(kind.key, kind.key): field}
    if component is None:
        return replace(block, **change)
    entries = (
        replace(entry, **change) if entry.name == component else entry for entry in block.components
    )
    return replace(block, components=tuple(entries))
