"""The compact form of a block: one line for the function, and one for each component.

    place 2 -> home 9/10, done 1/10
    power    6.674e-08   1 of 2
    gripper  := 2e-07    1        ! computed 7.344e-08; supplier derating
    hose     := add  1e-06       1        ! it holds the hose
    wrist    := omit              ! hangs free in this step

Lines are what follows the gutter. docs/blocks.md has the grammar.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import NO_FAILURES, ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.lines import (
    BlockLine,
    ValueText,
    forbid_conflict_marker,
    joined_comment,
    read_field,
)
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    COMPONENT_KINDS,
    FAILURES,
    NEXT,
    FieldKind,
    is_component_name,
    is_function_name,
)
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import BlockError, Location, UnpinnedReasonError

UNSTATED = "-"
"""What stands for a value that an omitted component leaves out."""

_QUOTED = r'"(?:[^"\\]|\\.)*"'
_LABEL = r"(?: \([^\s!{}(),;:=/]+(?: [^\s!{}(),;:=/]+)*\))?"
BARE_FUNCTION = rf"[\w<~](?:(?!:=)[^\s!{{}},;/\"])*{_LABEL}"
BARE_COMPONENT = r"[\w<~](?:(?!:=)[^\s!{}\"])*"
_PIN = r"(?::=)?"
_FUNCTION = re.compile(
    rf"(?P<name>{_QUOTED}|{BARE_FUNCTION})\s*(?P<added>(?<=\s):=\s*add(?=\s))?\s*"
    rf"(?P<callSequence_pin>{_PIN})(?<=[\s=])\s*(?P<rank>[^\s:!>-]+)\s*(?:->\s*(?P<next_pin>{_PIN})\s*(?P<next>.*))?"
)
_COMPONENT = re.compile(
    rf"(?P<name>{_QUOTED}|{BARE_COMPONENT})\s+(?:(?P<mark>:=\s*(?:add|omit))(?:\s+|\Z))?(?P<values>.*)"
)
_VALUES = re.compile(
    rf"(?P<probability_pin>{_PIN})\s*(?P<probability>[^\s:]+)\s+"
    rf"(?:(?P<group_pin>{_PIN})\s*(?P<required>\d+) of (?P<units>\d+)(?P<options>,.*)?"
    rf"|(?P<quantity_pin>{_PIN})\s*(?P<quantity>[^\s:,]+)"
    rf"(?:\s+(?P<redundancy_pin>{_PIN})\s*(?P<redundancy>[^:]+))?)"
)
_OF_FIELD = re.compile(
    r"(?P<key>callSequence|next|probability|quantity|redundancy)\s*(?:!\s*(?P<comment>.*))?"
)
GROUP = re.compile(r"(?:true|required (?P<required>\d+))(?P<options>,.*)?")
_COMPONENT_ALLOWED = (
    "`NAME PROBABILITY UNITS` or `NAME PROBABILITY REQUIRED of UNITS`, `:=` before a value that a "
    "user set; `NAME := add PROBABILITY UNITS`; `NAME := omit`"
)


def is_function_line(text: str) -> bool:
    """Return whether a line can be that of the function, whatever its values."""
    return _FUNCTION.fullmatch(text.partition("!")[0].strip()) is not None


def with_names(text: str, names: Mapping[str, str]) -> str:
    """Return a line of the function, or one that goes on with what follows it, under new names.

    `names` are the new names by the old ones.
    """
    words, mark, comment = text.partition("!")
    lead = words[: len(words) - len(words.lstrip())]
    body = words.removeprefix(lead)
    matched = _FUNCTION.fullmatch(body.rstrip())
    if matched is not None:
        name = _read_name(matched["name"])
        head, steps = body[matched.end("name") :], ""
        if matched["next"] is not None:
            head, steps = (
                body[matched.end("name") : matched.start("next")],
                body[matched.start("next") :],
            )
        body = printed_name(names.get(name, name), BARE_FUNCTION) + head
    elif body.startswith("->"):
        body, steps = "->", body.removeprefix("->")
    else:
        return text
    return lead + body + ",".join(_step(step, names) for step in steps.split(",")) + mark + comment


def printed_name(name: str, bare: str) -> str:
    """Return a name as a line holds it: in quotes unless it matches the pattern `bare`."""
    return name if re.fullmatch(bare, name) else json.dumps(name, ensure_ascii=False)


def _step(step: str, names: Mapping[str, str]) -> str:
    target, space, share = step.rstrip().rpartition(" ")
    name = target.strip()
    new = target.replace(name, names[name]) if name in names else target
    return new + space + share + step[len(step.rstrip()) :]


def _read_name(text: str) -> str:
    return str(json.loads(text)) if text.startswith('"') else text


class _Line(NamedTuple):
    """One line of the function or of a component, before its values are read."""

    number: int
    """The number of the line in the file."""
    parts: Mapping[str, str | None]
    """What the regular expression of the line matched, by group."""
    comments: dict[str, list[str]]
    """The comment of each value that a user set, by key; the empty key is the line's own."""


def read_compact(start: int, lines: Iterable[BlockLine], file: str) -> RiskBlock:
    """Return the block that `lines` state; `start` is the line before them, with the header.

    Raises:
        BlockError: if a line cannot be read, or a value is missing or not allowed.
    """
    reader = _Reader(file)
    function, *components = reader.lines(lines)
    block = reader.function(function, start)
    return replace(block, components=tuple(map(reader.component, components)))


class _Reader:
    def __init__(self, file: str) -> None:
        self._file = file

    def _error(self, line: int, message: str) -> BlockError:
        return BlockError(message, Location(self._file, line))

    def _unpinned(self, line: int, message: str) -> UnpinnedReasonError:
        return UnpinnedReasonError(message, Location(self._file, line))

    def lines(self, lines: Iterable[BlockLine]) -> list[_Line]:
        read: list[_Line] = []
        last: list[str] | None = None
        for line in lines:
            text = line.text.strip()
            if not text:
                continue
            forbid_conflict_marker(line, self._file)
            of_field = _OF_FIELD.fullmatch(text)
            if text.startswith("!"):
                if last is None:
                    raise self._unpinned(
                        line.number,
                        "a `!` line continues the reason of a `:=` value, but none precedes it",
                    )
                last.append(text[1:].strip())
            elif of_field is not None and read:
                last = self._comment_of(read[-1], of_field["key"], line.number)
                last.append(of_field["comment"] or "")
            else:
                words, mark, comment = text.partition("!")
                if text.startswith("->") and len(read) > 1:
                    read[-1], last = self._with_mode(read[-1], words.rstrip(), line.number)
                else:
                    if text.startswith("->") and read:
                        read[0] = _with_more_next(read[0], words)
                    else:
                        read.append(self._line(line.number, words.rstrip(), is_first=not read))
                    last = self._own_comment(read[-1])
                if last is None and mark:
                    raise self._unpinned(
                        line.number,
                        "a reason is allowed only for what a user set; write `:=` before the value",
                    )
                if last is not None:
                    if text.startswith("->") and not any(last):
                        last.clear()  # what it continues has nothing beside it
                    last.append(comment.strip())
        return read

    def _line(self, number: int, words: str, *, is_first: bool) -> _Line:
        matched = (_FUNCTION if is_first else _COMPONENT).fullmatch(words)
        if matched is None and is_first:
            raise self._error(
                number,
                f"cannot read `{words}`; a risk block begins with its function, `NAME RANK -> "
                "FUNCTION SHARE, FUNCTION SHARE`, or in the published form with `@Function {`",
            )
        parts = {} if matched is None else matched.groupdict()
        if not is_first:
            parts |= self._values(number, words, parts)
        return _Line(number, parts, {})

    def _values(
        self, number: int, words: str, parts: Mapping[str, str | None]
    ) -> dict[str, str | None]:
        values = parts.get("values") or ""
        matched = _VALUES.fullmatch(values)
        if matched is not None:
            return _spelled_out(matched.groupdict())
        if values or not (parts.get("mark") or "").endswith("omit"):
            raise self._error(
                number, f"cannot read `{words}` as a component; allowed: {_COMPONENT_ALLOWED}"
            )
        return dict.fromkeys((kind.key for kind in COMPONENT_KINDS), UNSTATED)

    def _with_mode(self, line: _Line, words: str, number: int) -> tuple[_Line, list[str] | None]:
        """Return the line of a component with one more mode, and where a reason of it goes."""
        before = line.parts.get(FAILURES.key)
        pin, _, text = words.removeprefix("->").strip().rpartition(":= ")
        mode = " ".join(text.split())
        pinned = bool(pin) or words.removeprefix("->").strip().startswith(":=")
        if before is not None and pinned != bool(line.parts.get(f"{FAILURES.key}_pin")):
            raise self._error(
                number, "the modes of a component are one value: write `:=` before all, or none"
            )
        parts = {
            **line.parts,
            FAILURES.key: mode if before is None else f"{before} | {mode}",
            f"{FAILURES.key}_pin": ":=" if pinned else None,
        }
        comment = line.comments.setdefault(FAILURES.key, []) if pinned else None
        return line._replace(parts=parts), comment

    def _own_comment(self, line: _Line) -> list[str] | None:
        """Return the comment on the line itself: that of what a user set first in it."""
        keys = _keys_set(line.parts)
        return line.comments.setdefault(keys[0], []) if keys else None

    def _comment_of(self, line: _Line, key: str, number: int) -> list[str]:
        keys = _keys_set(line.parts)
        if key not in keys:
            allowed = ", ".join(filter(None, keys)) or "no value of this line"
            raise self._unpinned(
                number, f"{key} has a reason but is not set by hand; set by hand: {allowed}"
            )
        if any(line.comments.get(key, ())):
            raise self._error(number, f"a second reason for {key}; keep one")
        return line.comments.setdefault(key, [])

    def function(self, line: _Line, start: int) -> RiskBlock:
        parts = line.parts
        name = self._name(line)
        if not is_function_name(name):
            raise self._error(line.number, f"{name} cannot be the qualified name of a function")
        following = None
        if parts["next"] is not None:
            steps = [" ".join(step.split()) for step in parts["next"].split(",")]
            following = self._field(line, NEXT, ", ".join(steps))
        return RiskBlock(
            name=name,
            call_sequence=self._field(line, CALL_SEQUENCE, parts["rank"] or ""),
            next=following,
            components=(),
            added=parts["added"] is not None,
            location=Location(self._file, start),
            reason=joined_comment(line.comments.get("", [])),
            reason_lines=tuple(line.comments.get("", [])),
        )

    def component(self, line: _Line) -> ComponentEntry:
        parts = line.parts
        name = self._name(line)
        if not is_component_name(name):
            raise self._error(line.number, f"`{name}` cannot be the name of a component")
        omitted = (parts["mark"] or "").endswith("omit")
        fields: list[Field[Any]] = []
        for kind, default in zip(COMPONENT_KINDS, (0.0, 1, Redundancy(False)), strict=True):
            text = " ".join((parts[kind.key] or "").split())
            if text == UNSTATED:
                if not omitted:
                    raise self._error(
                        line.number,
                        f"{kind.key} is left out; only `:= omit` components may do that",
                    )
                fields.append(Field(default, ""))
            else:
                fields.append(self._field(line, kind, text))
        probability, quantity, redundancy = fields
        modes = parts.get(FAILURES.key)
        return ComponentEntry(
            name=name,
            probability=probability,
            quantity=quantity,
            redundancy=redundancy,
            added=parts["mark"] is not None and not omitted,
            omitted=omitted,
            location=Location(self._file, line.number),
            reason=joined_comment(line.comments.get("", [])),
            reason_lines=tuple(line.comments.get("", [])),
            failures=NO_FAILURES if modes is None else self._field(line, FAILURES, modes),
        )

    def _field(self, line: _Line, kind: FieldKind, text: str) -> Field[Any]:
        pinned, comment = line.parts.get(f"{kind.key}_pin"), line.comments.get(kind.key, [])
        place = Location(self._file, line.number)
        return read_field(kind, ValueText(text, bool(pinned), comment, place))

    def _name(self, line: _Line) -> str:
        text = line.parts["name"] or ""
        try:
            return _read_name(text)
        except ValueError as error:
            raise self._error(
                line.number, f"cannot read the name {text}; allowed: a string as in JSON"
            ) from error


def _with_more_next(line: _Line, words: str) -> _Line:
    before = (line.parts["next"] or "").rstrip().removesuffix(",")
    more = words.removeprefix("->").strip()
    return line._replace(parts={**line.parts, "next": f"{before}, {more}" if before else more})


def _spelled_out(parts: dict[str, str | None]) -> dict[str, str | None]:
    """Return the values of a component with `REQUIRED of UNITS` as a quantity and a redundancy."""
    required = parts["required"]
    if required is None:
        return {**parts, "redundancy": parts["redundancy"] or "false"}
    words = "true" if required == "1" else f"required {required}"
    return {
        **parts,
        "quantity": parts["units"],
        "redundancy": words + (parts["options"] or ""),
        "quantity_pin": parts["group_pin"],
        "redundancy_pin": parts["group_pin"],
    }


def _keys_set(parts: Mapping[str, str | None]) -> list[str]:
    """Return the keys of what a user set in a line, in their order; the empty one for the whole."""
    whole = [""] if parts.get("added") or parts.get("mark") else []
    kinds = (CALL_SEQUENCE, NEXT, *COMPONENT_KINDS)
    return [*whole, *(kind.key for kind in kinds if parts.get(f"{kind.key}_pin"))]
