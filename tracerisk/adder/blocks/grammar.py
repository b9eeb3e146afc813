"""The text of a risk annotation block: parse it, report each mistake with its line, and print it.

A block is comment lines after the gutter `# | `, which no linter takes for dead code.
Here a line is what follows the gutter; finding blocks in a file is the job of `sources/read.py`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.conflicts import is_conflict_marker
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    COMPONENT_KINDS,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
    is_component_name,
    is_function_name,
)
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import BlockError, Location, one_of

GUTTER = "# | "
HEADER = "RiskAnnotation"
DIGEST = "[0-9A-Za-z]{6}(?:-[0-9A-Za-z]{6})*"
"""What may follow the header: see `adder/lock/digest.py`."""

DEFAULT_WIDTH = 79
"""The width that printed lines keep to, the indentation included, where words allow it."""
_NARROWEST, _TAB_COLUMNS = 40, 8

WITH_EVIDENCE = "with evidence"
"""What follows the header of a block whose values take evidence into account."""

HEADER_LINE = rf"{HEADER}(?:[ \t]+(?P<digest>{DIGEST}))?(?P<evidence>[ \t]+{WITH_EVIDENCE})?"
"""The line with which a block begins, as a regular expression."""

_HEADER = re.compile(HEADER_LINE)
_SECTION = re.compile(r"@(?P<kind>\w*)\s*(?P<mark>:=\s*omit\b|:=)?\s*\{\s*(?P<rest>.*)")
_ASSIGNMENT = re.compile(r"(?P<key>\w+)\s*(?P<operator>:?=)\s*(?P<rest>.*)")
_LETTER = r"[^\W\d]"
_FUNCTION_KEYS = ("name", "callSequence", "next")
_COMPONENT_KEYS = ("name", *(kind.key for kind in COMPONENT_KINDS))


class BlockLine(NamedTuple):
    """One line of a block."""

    number: int
    """The number of the line in the file, from 1."""
    text: str
    """The text after the gutter."""


class _Assignment(NamedTuple):
    """A `key = value` line with all of its comment."""

    key: str
    """The key, such as `probability`."""
    pinned: bool
    """Whether the operator is `:=`."""
    value: str
    """The text between operator and comment."""
    comment: list[str]
    """The comment after `!`, line by line, with its further lines."""
    line: int
    """The number of the line in the file."""


class _Section(NamedTuple):
    """One `@Function { ... }` or `@Component { ... }` before its values are read."""

    kind: str
    """`Function` or `Component`."""
    by_hand: bool
    """Whether the mark is `:=`."""
    omitted: bool
    """Whether the mark is `:= omit`."""
    comment: list[str]
    """The comment after the brace, line by line."""
    line: int
    """The number of its first line in the file."""
    assignments: list[_Assignment]
    """The lines between the braces."""


def is_header(text: str) -> bool:
    """Return whether a line begins a block, with a digest or without."""
    return _HEADER.fullmatch(text.strip()) is not None


def parse_block(lines: Sequence[BlockLine], file: str) -> RiskBlock:
    """Return the block that `lines` state, from its `RiskAnnotation` line to its last brace.

    Raises:
        BlockError: if a line is unknown or malformed, a brace or a value is missing, or a name
            is given twice; with the file and the line.
    """
    return _Parser(file).block(lines)


class _Parser:
    def __init__(self, file: str) -> None:
        self._file = file

    def _error(self, line: int, message: str) -> BlockError:
        return BlockError(message, Location(self._file, line))

    def block(self, lines: Sequence[BlockLine]) -> RiskBlock:
        header = _HEADER.fullmatch(lines[0].text.strip()) if lines else None
        if header is None:
            number = lines[0].number if lines else 1
            raise self._error(number, f"a risk block begins with the line `{GUTTER}{HEADER}`")
        start = lines[0].number
        sections = self._sections(lines[1:])
        functions = [section for section in sections if section.kind == "Function"]
        if not functions:
            raise self._error(
                start, "this risk block has no `@Function {` with a name and callSequence"
            )
        if len(functions) > 1:
            raise self._error(
                functions[1].line, "a risk block has one `@Function`; this is a second"
            )
        components = tuple(
            self._component(section) for section in sections if section.kind == "Component"
        )
        seen: dict[str, int] = {}
        for component in components:
            line = component.location.line if component.location else start
            assert line is not None
            if component.name in seen:
                raise self._error(
                    line,
                    f"duplicate component {component.name} in this block, first at line "
                    f"{seen[component.name]}; delete one",
                )
            seen[component.name] = line
        return self._function(functions[0], components, start, header)

    def _sections(self, lines: Iterable[BlockLine]) -> list[_Section]:
        sections: list[_Section] = []
        is_open = False
        for line in lines:
            text = line.text.strip()
            if not text:
                continue
            if text[0] in "<>=|" and is_conflict_marker(text):
                raise self._error(
                    line.number,
                    f"`{text}` is a conflict marker in a risk block; resolve the merge, then "
                    "run the same command again",
                )
            if text.startswith("@"):
                if is_open:
                    raise self._error(
                        line.number,
                        f"`{text}` begins before the section of line {sections[-1].line} is "
                        "closed; write `}` first",
                    )
                sections.append(self._section_header(line.number, text))
                is_open = True
            elif text.startswith("!"):
                self._comment_of_last(sections, is_open, line.number).append(text[1:].strip())
            elif not is_open:
                raise self._error(
                    line.number,
                    f"unexpected `{text}`; allowed here: @Function {{, @Component {{, "
                    "or the end of the comment",
                )
            elif text == "}":
                is_open = False
            else:
                sections[-1].assignments.append(self._assignment(sections[-1], line.number, text))
        if is_open:
            raise self._error(
                sections[-1].line, f"the `@{sections[-1].kind} {{` of this line has no `}}`"
            )
        return sections

    def _section_header(self, line: int, text: str) -> _Section:
        match = _SECTION.fullmatch(text)
        kind = match["kind"] if match else ""
        allowed = "@Function {, @Function := {, @Component {, @Component := {, @Component := omit {"
        if match is None or kind not in ("Function", "Component"):
            raise self._error(line, f"cannot read `{text}`; allowed: {allowed}")
        mark = match["mark"] or ""
        omitted = mark.endswith("omit")
        if omitted and kind == "Function":
            raise self._error(line, f"a function cannot be omitted; allowed: {allowed}")
        rest = match["rest"]
        if rest and not rest.startswith("!"):
            raise self._error(line, f"unexpected `{rest}` after the brace; allowed: `! a reason`")
        if rest and not mark:
            raise self._error(line, "a reason may follow only what a user set; write `:= {`")
        comment = [rest[1:].strip()] if rest else []
        return _Section(kind, bool(mark), omitted, comment, line, [])

    def _comment_of_last(self, sections: list[_Section], is_open: bool, line: int) -> list[str]:
        last = sections[-1] if sections and is_open else None
        if last is not None and last.assignments:
            if last.assignments[-1].pinned:
                return last.assignments[-1].comment
        elif last is not None and last.by_hand:
            return last.comment
        raise self._error(
            line, "a `!` line continues the reason of a `:=` line, but none precedes it"
        )

    def _assignment(self, section: _Section, line: int, text: str) -> _Assignment:
        allowed = _FUNCTION_KEYS if section.kind == "Function" else _COMPONENT_KEYS
        match = _ASSIGNMENT.fullmatch(text)
        if match is None:
            raise self._error(
                line, f"cannot read `{text}`; allowed: }}, {', '.join(_lines_of(allowed))}"
            )
        key = match["key"]
        if key not in allowed:
            raise self._error(
                line, f"unknown key {key} in `@{section.kind}`; {one_of(allowed, key)}"
            )
        if key != "next":
            for earlier in section.assignments:
                if earlier.key == key:
                    raise self._error(
                        line, f"duplicate {key}, first at line {earlier.line}; delete one"
                    )
        pinned = match["operator"] == ":="
        value, mark, comment = match["rest"].partition("!")
        if key == "name" and pinned:
            raise self._error(line, "a name cannot be set by hand; write `name = `")
        if mark and not pinned:
            raise self._error(
                line, f"a reason is allowed only for a value set by hand; write `{key} := `"
            )
        return _Assignment(key, pinned, value.strip(), [comment.strip()] if mark else [], line)

    def _function(
        self,
        section: _Section,
        components: tuple[ComponentEntry, ...],
        start: int,
        header: re.Match[str],
    ) -> RiskBlock:
        name = self._name(section)
        if not is_function_name(name.value):
            raise self._error(name.line, f"{name.value} cannot be the qualified name of a function")
        call_sequence = self._field(section, CALL_SEQUENCE)
        if call_sequence is None:
            raise self._missing(section, CALL_SEQUENCE)
        return RiskBlock(
            name=name.value,
            call_sequence=call_sequence,
            next=self._next(section),
            components=components,
            added=section.by_hand,
            location=Location(self._file, start),
            reason=_joined(section.comment),
            digest=header["digest"],
            has_evidence=header["evidence"] is not None,
        )

    def _component(self, section: _Section) -> ComponentEntry:
        name = self._name(section)
        if not is_component_name(name.value):
            raise self._error(name.line, f"`{name.value}` cannot be the name of a component")
        fields: list[Field[Any]] = []
        for kind, default in zip(COMPONENT_KINDS, (0.0, 1, Redundancy(False)), strict=True):
            field = self._field(section, kind)
            if field is None and not section.omitted:
                raise self._missing(section, kind)
            fields.append(Field(default, "") if field is None else field)
        probability, quantity, redundancy = fields
        return ComponentEntry(
            name=name.value,
            probability=probability,
            quantity=quantity,
            redundancy=redundancy,
            added=section.by_hand and not section.omitted,
            omitted=section.omitted,
            location=Location(self._file, section.line),
            reason=_joined(section.comment),
        )

    def _name(self, section: _Section) -> _Assignment:
        for assignment in section.assignments:
            if assignment.key == "name":
                return assignment
        raise self._error(section.line, f"this `@{section.kind}` has no `name = ` line")

    def _missing(self, section: _Section, kind: FieldKind) -> BlockError:
        return self._error(section.line, f"this `@{section.kind}` has no `{kind.key} = ` line")

    def _field(self, section: _Section, kind: FieldKind) -> Field[Any] | None:
        for assignment in section.assignments:
            if assignment.key == kind.key:
                return self._read(kind, assignment, assignment.value, assignment.comment)
        return None

    def _next(self, section: _Section) -> Field[Any] | None:
        lines = [assignment for assignment in section.assignments if assignment.key == "next"]
        if not lines:
            return None
        first = lines[0]
        for other in lines[1:]:
            if other.pinned != first.pinned:
                raise self._error(
                    other.line,
                    "the `next` lines of a block are one value: write `=` on all, or `:=` on all",
                )
        commented = [line.comment for line in lines if line.comment]
        if len(commented) > 1:
            raise self._error(
                lines[-1].line, "the `next` lines of a block are one value with one reason"
            )
        texts = []
        for line in lines:
            if "," in line.value:
                raise self._error(
                    line.line, f"next = {line.value}: one `next` line for each target"
                )
            texts.append(" ".join(line.value.split()))
        return self._read(NEXT, first, ", ".join(texts), commented[0] if commented else [])

    def _read(self, kind: FieldKind, at: _Assignment, text: str, comment: list[str]) -> Field[Any]:
        joined = _joined(comment)
        computed, reason = _split_comment(joined)
        if computed is not None and computed != NOTHING_COMPUTED:
            if re.match(_LETTER, computed) and not _is_readable(kind, computed):
                # A reason that begins with this word.
                computed, reason = None, joined
            else:
                self._value(kind, at, computed, "! computed ")
        return Field(
            value=self._value(kind, at, text, "= "),
            text=text,
            pinned=at.pinned,
            computed=computed,
            reason=reason,
            location=Location(self._file, at.line),
        )

    def _value(self, kind: FieldKind, at: _Assignment, text: str, before: str) -> Any:
        try:
            return kind.read(text)
        except ValueError as error:
            message = f"{kind.key} {before}{text} is not allowed; allowed: {error}"
            for mark in "#;":
                value, _, reason = text.partition(mark)
                if reason and _is_readable(kind, value.strip()):
                    words = f"{kind.key} := {value.strip()}  ! {reason.strip()}"
                    message = f"put a reason after `!`, not after `{mark}`; write `{words}`"
            raise self._error(at.line, message) from error


def _is_readable(kind: FieldKind, text: str) -> bool:
    try:
        kind.read(text)
    except ValueError:
        return False
    return True


def _joined(comment: list[str]) -> str | None:
    """Return the parts of a comment as one text in single spaces; `None` for nothing."""
    return " ".join(" ".join(comment).split()) or None if comment else None


def _split_comment(comment: str | None) -> tuple[str | None, str | None]:
    """Return what a comment says was computed, and the reason it gives."""
    if comment is None:
        return None, None
    if comment.startswith("computed "):
        computed, _, reason = comment.removeprefix("computed ").partition(";")
        return computed.strip(), reason.strip() or None
    return None, comment.removeprefix(";").strip() or None


def _comment_text(computed: str | None, reason: str | None) -> str | None:
    """Return the comment that `_split_comment` splits into the same two parts."""
    if computed is not None:
        return f"computed {computed}; {reason}" if reason else f"computed {computed}"
    if reason is not None and reason.startswith(("computed ", ";")):
        return f"; {reason}"
    return reason


def _lines_of(keys: Iterable[str]) -> list[str]:
    return [f"{key} =" for key in keys]


def width_behind(indent: bytes) -> int:
    """Return how wide the lines of a block may be after an indentation."""
    return max(_NARROWEST, DEFAULT_WIDTH - len(indent.expandtabs(_TAB_COLUMNS)))


def print_block(block: RiskBlock, width: int = DEFAULT_WIDTH) -> tuple[str, ...]:
    """Return the lines of a block, gutter included, without indentation and line ends.

    `width` is the room for a line; reasons are wrapped to it.
    Parsed again, the lines give the same block.
    """
    marks = [block.digest or "", WITH_EVIDENCE if block.has_evidence else ""]
    lines = [" ".join([HEADER, *(mark for mark in marks if mark)])]
    lines += _print_header("Function", block.added, False, block.reason, width)
    lines.append(f"  name = {block.name}")
    lines += _print_field(CALL_SEQUENCE, block.call_sequence, width)
    if block.next is not None:
        lines += _print_field(NEXT, block.next, width)
    lines.append("}")
    for component in block.components:
        lines += _print_header(
            "Component",
            component.added or component.omitted,
            component.omitted,
            component.reason,
            width,
        )
        lines.append(f"  name = {component.name}")
        for kind, value in component_fields(component):
            if value.is_stated:
                lines += _print_field(kind, value, width)
        lines.append("}")
    return tuple(GUTTER + line for line in lines)


def _print_header(
    kind: str, by_hand: bool, omitted: bool, reason: str | None, width: int
) -> list[str]:
    mark = ":= omit " if omitted else ":= " if by_hand else ""
    return _with_comment(f"@{kind} {mark}{{", reason, width)


def _print_field(kind: FieldKind, field: Field[Any], width: int) -> list[str]:
    operator = ":=" if field.pinned else "="
    values = field.text.split(", ") if kind is NEXT else [field.text]
    lines = [f"  {kind.key} {operator} {value}" for value in values]
    comment = _comment_text(field.computed, field.reason)
    return lines[:-1] + _with_comment(lines[-1], comment, width)


def _with_comment(line: str, comment: str | None, width: int) -> list[str]:
    """Return `line` with its comment, wrapped onto lines of its own where the room ends."""
    if comment is None:
        return [line]
    room = width - len(GUTTER)
    lines, mark = [line], "  !"
    for word in comment.split(" "):
        if len(lines[-1]) + len(mark) + 1 + len(word) > room:
            lines.append("    !")
            mark = ""
        lines[-1] += f"{mark} {word}"
        mark = ""
    return lines
