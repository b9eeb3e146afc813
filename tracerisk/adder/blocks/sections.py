"""The published form of a block: a section of `key = value` lines for the function and for each
component. Lines are what follows the gutter.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import NO_FAILURES, ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.lines import (
    FURTHER,
    BlockLine,
    ValueText,
    field_with_comment,
    forbid_conflict_marker,
    joined_comment,
    read_field,
    with_comment,
    wrapped,
)
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    COMPONENT_KINDS,
    FAILURES,
    NEXT,
    FieldKind,
    component_fields,
    is_component_name,
    is_function_name,
)
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import BlockError, Location, UnpinnedReasonError, one_of

_SECTION = re.compile(r"@(?P<kind>\w*)\s*(?P<mark>:=\s*omit\b|:=)?\s*\{\s*(?P<rest>.*)")
_ASSIGNMENT = re.compile(r"(?P<key>\w+)\s*(?P<operator>:?=)\s*(?P<rest>.*)")
_FUNCTION_KEYS = ("name", "callSequence", "next")
_COMPONENT_KEYS = ("name", *(kind.key for kind in COMPONENT_KINDS))
_FAILURE_KEYS = ("component", "mode")
_KEYS = {"Function": _FUNCTION_KEYS, "Component": _COMPONENT_KEYS, "Failure": _FAILURE_KEYS}
_REPEATED = {"next": NEXT, "mode": FAILURES}


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
    """One `@Function { ... }`, `@Component` or `@Failure`, before its values are read."""

    kind: str
    """`Function`, `Component` or `Failure`."""
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


def read_sections(start: int, lines: Iterable[BlockLine], file: str) -> RiskBlock:
    """Return the block that `lines` state; `start` is the line before them, with the header.

    Raises:
        BlockError: if a line is unknown or malformed, or a brace or a value is missing.
    """
    return _Parser(file).block(start, lines)


class _Parser:
    def __init__(self, file: str) -> None:
        self._file = file

    def _error(self, line: int, message: str) -> BlockError:
        return BlockError(message, Location(self._file, line))

    def _unpinned(self, line: int, message: str) -> UnpinnedReasonError:
        return UnpinnedReasonError(message, Location(self._file, line))

    def block(self, start: int, lines: Iterable[BlockLine]) -> RiskBlock:
        sections = self._sections(lines)
        functions = [section for section in sections if section.kind == "Function"]
        if not functions:
            raise self._error(
                start, "this risk block has no `@Function {` with a name and callSequence"
            )
        if len(functions) > 1:
            raise self._error(
                functions[1].line, "a risk block has one `@Function`; this is a second"
            )
        failures = self._failures(sections)
        components = tuple(
            self._component(section, failures)
            for section in sections
            if section.kind == "Component"
        )
        for name, (section, _) in failures.items():
            raise self._error(
                section.line, f"`@Failure` of {name}, which is no component of this block"
            )
        return self._function(functions[0], components, start)

    def _sections(self, lines: Iterable[BlockLine]) -> list[_Section]:
        sections: list[_Section] = []
        is_open = False
        for line in lines:
            text = line.text.strip()
            if not text:
                continue
            forbid_conflict_marker(line, self._file)
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
                comment = self._comment_of_last(sections, is_open, line.number)
                # Nothing of it stands beside the value.
                comment += [text[1:].strip()] if comment else ["", text[1:].strip()]
            elif not is_open:
                raise self._error(
                    line.number,
                    f"unexpected `{text}`; allowed here: @Function {{, @Component {{, @Failure {{, "
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
        allowed = (
            "@Function {, @Function := {, @Component {, @Component := {, @Component := omit {, "
            "@Failure {"
        )
        if match is None or kind not in _KEYS:
            raise self._error(line, f"cannot read `{text}`; allowed: {allowed}")
        mark = match["mark"] or ""
        omitted = mark.endswith("omit")
        if omitted and kind == "Function":
            raise self._error(line, f"a function cannot be omitted; allowed: {allowed}")
        if mark and kind == "Failure":
            raise self._error(line, "write `@Failure {`, and `mode :=` for what a user set")
        rest = match["rest"]
        if rest and not rest.startswith("!"):
            raise self._error(line, f"unexpected `{rest}` after the brace; allowed: `! a reason`")
        if rest and not mark:
            raise self._unpinned(line, "a reason may follow only what a user set; write `:= {`")
        comment = [rest[1:].strip()] if rest else []
        return _Section(kind, bool(mark), omitted, comment, line, [])

    def _comment_of_last(self, sections: list[_Section], is_open: bool, line: int) -> list[str]:
        last = sections[-1] if sections and is_open else None
        if last is not None and last.assignments:
            if last.assignments[-1].pinned:
                return last.assignments[-1].comment
        elif last is not None and last.by_hand:
            return last.comment
        raise self._unpinned(
            line, "a `!` line continues the reason of a `:=` line, but none precedes it"
        )

    def _assignment(self, section: _Section, line: int, text: str) -> _Assignment:
        allowed = _KEYS[section.kind]
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
        if key not in _REPEATED:
            for earlier in section.assignments:
                if earlier.key == key:
                    raise self._error(
                        line, f"duplicate {key}, first at line {earlier.line}; delete one"
                    )
        pinned = match["operator"] == ":="
        value, mark, comment = match["rest"].partition("!")
        if key in ("name", "component") and pinned:
            raise self._error(line, f"a name cannot be set by hand; write `{key} = `")
        if mark and not pinned:
            raise self._unpinned(
                line, f"a reason is allowed only for a value set by hand; write `{key} := `"
            )
        return _Assignment(key, pinned, value.strip(), [comment.strip()] if mark else [], line)

    def _function(
        self,
        section: _Section,
        components: tuple[ComponentEntry, ...],
        start: int,
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
            next=self._lines(section, "next", ", "),
            components=components,
            added=section.by_hand,
            location=Location(self._file, start),
            reason=joined_comment(section.comment),
            reason_lines=tuple(section.comment),
        )

    def _failures(self, sections: list[_Section]) -> dict[str, tuple[_Section, Field[Any]]]:
        """Return what follows the failures of components, by name."""
        found: dict[str, tuple[_Section, Field[Any]]] = {}
        for section in sections:
            if section.kind != "Failure":
                continue
            name = self._name(section, "component").value
            if name in found:
                raise self._error(
                    section.line,
                    f"a second `@Failure` of {name}, first at line {found[name][0].line}; write "
                    "one with a `mode` line for each mode",
                )
            field = self._lines(section, "mode", " | ")
            if field is None:
                raise self._error(section.line, "this `@Failure` has no `mode = ` line")
            found[name] = section, field
        return found

    def _component(
        self, section: _Section, failures: dict[str, tuple[_Section, Field[Any]]]
    ) -> ComponentEntry:
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
        _, of_failures = failures.pop(name.value, (section, NO_FAILURES))
        return ComponentEntry(
            name=name.value,
            probability=probability,
            quantity=quantity,
            redundancy=redundancy,
            added=section.by_hand and not section.omitted,
            omitted=section.omitted,
            location=Location(self._file, section.line),
            reason=joined_comment(section.comment),
            reason_lines=tuple(section.comment),
            failures=of_failures,
        )

    def _name(self, section: _Section, key: str = "name") -> _Assignment:
        for assignment in section.assignments:
            if assignment.key == key:
                return assignment
        raise self._error(section.line, f"this `@{section.kind}` has no `{key} = ` line")

    def _missing(self, section: _Section, kind: FieldKind) -> BlockError:
        return self._error(section.line, f"this `@{section.kind}` has no `{kind.key} = ` line")

    def _field(self, section: _Section, kind: FieldKind) -> Field[Any] | None:
        for assignment in section.assignments:
            if assignment.key == kind.key:
                return read_field(kind, self._stated(assignment, assignment.value))
        return None

    def _lines(self, section: _Section, key: str, mark: str) -> Field[Any] | None:
        """Return the field that all lines of one key make, joined by a mark."""
        lines = [assignment for assignment in section.assignments if assignment.key == key]
        if not lines:
            return None
        first = lines[0]
        for other in lines[1:]:
            if other.pinned != first.pinned:
                raise self._error(
                    other.line,
                    f"the `{key}` lines of a section are one value: write `=` on all, or `:=` "
                    "on all",
                )
        commented = [line.comment for line in lines if line.comment]
        if len(commented) > 1:
            raise self._error(
                lines[-1].line, f"the `{key}` lines of a section are one value with one reason"
            )
        texts = []
        for line in lines:
            if mark.strip() in line.value:
                each = "target" if key == "next" else "mode"
                raise self._error(
                    line.line, f"{key} = {line.value}: one `{key}` line for each {each}"
                )
            texts.append(" ".join(line.value.split()))
        first = first._replace(comment=commented[0] if commented else [])
        return read_field(_REPEATED[key], self._stated(first, mark.join(texts)))

    def _stated(self, at: _Assignment, text: str) -> ValueText:
        return ValueText(text, at.pinned, at.comment, Location(self._file, at.line))


def _lines_of(keys: Iterable[str]) -> list[str]:
    return [f"{key} =" for key in keys]


def print_sections(block: RiskBlock, width: int) -> list[str]:
    """Return the lines of a block behind its header, without gutter, indentation and line ends."""
    lines = with_comment(
        "@Function := {" if block.added else "@Function {", block.reason, width, block.reason_lines
    )
    lines.append(f"  name = {block.name}")
    lines += _print_field(CALL_SEQUENCE, block.call_sequence, width)
    if block.next is not None:
        lines += _print_field(NEXT, block.next, width)
    lines.append("}")
    for component in block.components:
        mark = ":= omit " if component.omitted else ":= " if component.added else ""
        lines += with_comment(
            f"@Component {mark}{{", component.reason, width, component.reason_lines
        )
        lines.append(f"  name = {component.name}")
        for kind, value in component_fields(component):
            if value.is_stated and kind is not FAILURES:
                lines += _print_field(kind, value, width)
        lines.append("}")
        if component.failures.is_stated:
            lines += ["@Failure {", f"  component = {component.name}"]
            lines += _print_field(FAILURES, component.failures, width)
            lines.append("}")
    return lines


def _print_field(kind: FieldKind, field: Field[Any], width: int) -> list[str]:
    operator = ":=" if field.pinned else "="
    key, mark = {NEXT: (kind.key, ", "), FAILURES: ("mode", " | ")}.get(kind, (kind.key, "\n"))
    lines = []
    for value in field.text.split(mark):
        items = value.split(", ") if kind is FAILURES else [value]
        lines += wrapped(f"  {key} {operator} ", items, FURTHER, width)
    return lines[:-1] + field_with_comment(lines[-1], field, width)
