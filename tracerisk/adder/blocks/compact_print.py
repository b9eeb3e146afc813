"""The compact form of a block, printed; `compact` reads it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.compact import (
    BARE_COMPONENT,
    BARE_FUNCTION,
    GROUP,
    UNSTATED,
    printed_name,
)
from tracerisk.adder.blocks.lines import (
    FURTHER,
    comment_text,
    field_with_comment,
    with_comment,
    wrapped,
)
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    NEXT,
    FieldKind,
    component_fields,
)

_PROBABILITY_WIDTH, _COUNT_WIDTH = 10, 7  # characters


def print_compact(block: RiskBlock, width: int) -> list[str]:
    """Return the lines of a block behind its header, without gutter, indentation and line ends."""
    lines = _print_function(block, width)
    names = [printed_name(entry.name, BARE_COMPONENT) for entry in block.components]
    room = max(map(len, names), default=0)
    for name, entry in zip(names, block.components, strict=True):
        lines += _print_component(f"{name:{room}}", entry, width)
    return lines


def _print_function(block: RiskBlock, width: int) -> list[str]:
    mark = " := add" if block.added else ""
    name = printed_name(block.name, BARE_FUNCTION)
    lines = [f"{name}{mark} {_marked(block.call_sequence)}"]
    fields: list[tuple[FieldKind, Field[Any]]] = [(CALL_SEQUENCE, block.call_sequence)]
    if block.next is not None:
        fields.append((NEXT, block.next))
        lines = wrapped(f"{lines[0]} -> ", _marked(block.next).split(", "), "  -> ", width)
    by_hand = (block.reason, block.reason_lines) if block.added else None
    return lines[:-1] + _with_comments(lines[-1], by_hand, fields, width)


def _print_component(name: str, entry: ComponentEntry, width: int) -> list[str]:
    fields = component_fields(entry)[:-1]
    mark = ":= add" if entry.added else ":= omit" if entry.omitted else ""
    values = [
        f"{_marked(entry.probability):{_PROBABILITY_WIDTH}}",
        f"{_printed_count(entry):{_COUNT_WIDTH}}",
    ]
    if entry.omitted and not any(value.is_stated for _, value in fields):
        values = [f"{mark:{_PROBABILITY_WIDTH}}", " " * _COUNT_WIDTH]
    elif mark:
        values = [mark, *values]
    by_hand = (entry.reason, entry.reason_lines) if entry.added or entry.omitted else None
    lines = _with_comments("  ".join((name, *values)), by_hand, fields, width)
    return lines + _print_modes(entry.failures, width)


def _print_modes(failures: Field[Any], width: int) -> list[str]:
    if not failures.is_stated:
        return []
    mark = ":= " if failures.pinned else ""
    lines = [
        line
        for mode in failures.text.split(" | ")
        for line in wrapped(f"  -> {mark}", mode.split(", "), FURTHER, width)
    ]
    return lines[:-1] + field_with_comment(lines[-1], failures, width)


def _marked(field: Field[Any]) -> str:
    if not field.is_stated:
        return UNSTATED
    return f":= {field.text}" if field.pinned else field.text


def _printed_count(entry: ComponentEntry) -> str:
    quantity, redundancy = entry.quantity, entry.redundancy
    group = GROUP.fullmatch(redundancy.text)
    is_one = quantity.is_stated and quantity.pinned == redundancy.pinned
    if group is not None and is_one and group["required"] != "1":
        words = f"{group['required'] or 1} of {quantity.text}{group['options'] or ''}"
        return f":= {words}" if quantity.pinned else words
    if redundancy.text == "false" and not redundancy.pinned:
        return _marked(quantity)
    return f"{_marked(quantity)} {_marked(redundancy)}"


def _with_comments(
    line: str,
    by_hand: tuple[str | None, Sequence[str]] | None,
    fields: Iterable[tuple[FieldKind, Field[Any]]],
    width: int,
) -> list[str]:
    """Return a line with the reason of what a user set first, and one for each further reason.

    `by_hand` is the reason for the whole line, with its lines; `None` where the tool gave it.
    """
    comments = [] if by_hand is None else [("", *by_hand)]
    comments += [
        (kind.key, comment_text(value.computed, value.reason), value.comment_lines)
        for kind, value in fields
        if value.pinned
    ]
    first, *others = comments or [("", None, ())]
    padded = line if first[1] is not None else line.rstrip()
    lines = with_comment(padded, first[1], width, first[2])
    for key, comment, typed in others:
        if comment is not None:
            lines += with_comment(f"  {key}", comment, width, typed)
    return lines
