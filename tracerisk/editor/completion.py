"""What may stand at a place in a risk block: sections, keys, and the values that are known."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from tracerisk.adder.blocks.compact import is_function_line
from tracerisk.adder.blocks.lines import GUTTER, HEADER
from tracerisk.adder.blocks.values import COMPONENT_KINDS, DONE, NEXT
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.hardware.model import Component, Hardware
from tracerisk.common.hardware.source_files import sysml_files
from tracerisk.config import Settings
from tracerisk.editor.figures import ControllerFigures
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.check.check import given_options
from tracerisk.pipeline.freshness.run_inputs import RunInputs

_LINE = re.compile(r"(?P<gutter>\s*(?:#\s?\||\*)\s?)(?P<text>.*)")
_HEADER = re.compile(rf"{HEADER}\b")
_SECTION = re.compile(r"@(?P<kind>Function|Component)\b(?P<mark>\s*:=)?")
_KEYED = re.compile(r"(?P<key>\w+)\s*:?=\s*(?P<value>.*)")
_COMPACT = "compact"
_SECTIONS = {
    "@Component := {": "a component that the tool does not compute, added by hand",
    "@Component := omit {": "a component excluded from the function's risk",
    "@Component {": "a component as the tool writes it",
    "@Function {": "the function that the block describes",
}
_KEYS = {
    "name": "the component's, or the function's qualified name",
    "callSequence": "the function's rank by its first visit",
    "next": "a function that follows (or done), and how often",
    "probability": "that one unit fails in one visit",
    "quantity": "how many units there are",
    "redundancy": "false: each unit is needed; true: one suffices",
}
_REDUNDANCIES = {
    "false": "each unit is needed",
    "true": "one unit suffices",
    "required 2": "as many units must work",
    "true, spare cold": "the others wait, and do not fail before",
    "true, spare warm 0.1": "the others wait, and fail at that share of the rate",
    "true, common_cause 0.1": "that share of failures hits every unit",
    "true, detected each_visit": "all units work again at each visit",
}


@dataclass(frozen=True, slots=True)
class Offer:
    """What may be inserted in place of the word that ends at the cursor."""

    text: str
    """The text to insert."""
    about: str
    """A short explanation for the editor's list."""
    kind: str
    """`section`, `key`, `value` or `name`."""
    typed: str = ""
    """What stands there already, which it replaces."""


@dataclass(frozen=True, slots=True)
class _Place:
    """Where the cursor is: the section that is open, and what it holds."""

    section: str
    """`Function`, `Component`, or empty between two of them; `compact` in a block of that form."""
    values: Mapping[str, str]
    """What the other lines of the section state, by key."""
    components: tuple[str, ...]
    """The names of the block's components."""


@dataclass(slots=True)
class _Section:
    """One section as it is read."""

    kind: str
    """`Function` or `Component`."""
    first: int
    """The line that opens it, from 0."""
    last: int = sys.maxsize
    """The line of its closing brace, from 0; `sys.maxsize` while it is open."""
    values: dict[str, str] = field(default_factory=dict)
    """The values that it states, by key."""


def offers(
    lines: Sequence[str],
    line: int,
    before: str,
    figures: Sequence[ControllerFigures],
    *,
    file: str,
    functions: Sequence[str],
) -> Iterator[Offer]:
    """Yield what may stand at the end of `before`, the begin of a line, from 0, of a source.

    `functions` are the qualified names of the source's functions, the nearest above first.
    """
    matched = _LINE.fullmatch(before)
    if matched is None:
        return
    text = matched["text"].lstrip()
    place = _place(lines, line)
    if place is None:
        if not is_c(file) and HEADER.startswith(text):
            yield from _whole_block(functions, matched["gutter"], text)
        return
    keyed = _KEYED.fullmatch(text)
    if place.section == _COMPACT:
        yield from _compact(place, text, figures)
    elif not place.section:
        for section, about in _SECTIONS.items():
            if section.startswith(text):
                yield Offer(section, about, "section", text)
    elif keyed is not None:
        yield from _values(place, keyed["key"], keyed["value"], figures, functions)
    elif re.fullmatch(r"\w*", text):
        of_function = ("name", "callSequence", "next")
        of_component = ("name", *(kind.key for kind in COMPONENT_KINDS))
        for key in of_function if place.section == "Function" else of_component:
            if key.startswith(text) and (key == NEXT.key or key not in place.values):
                yield Offer(f"{key} = ", _KEYS[key], "key", text)


def _place(lines: Sequence[str], line: int) -> _Place | None:
    """Return the section around a line; `None` outside a block."""
    begin = line - 1
    while (text := _behind_gutter(lines, begin)) is not None and not _HEADER.match(text):
        begin -= 1
    if text is None:
        return None
    sections: list[_Section] = []
    number = begin + 1
    own = _behind_gutter(lines, number)
    if number < line and own and is_function_line(own):
        return _Place(_COMPACT, {}, tuple(_compact_names(lines, number + 1, line)))
    while (text := _behind_gutter(lines, number)) is not None and not _HEADER.match(text):
        header, keyed = _SECTION.match(text), _KEYED.fullmatch(text)
        if number == line:
            pass  # is being typed
        elif header is not None:
            sections.append(_Section(header["kind"], number))
        elif text == "}" and sections:
            sections[-1].last = min(sections[-1].last, number)
        elif keyed is not None and sections:
            sections[-1].values.setdefault(keyed["key"], keyed["value"].strip())
        number += 1
    opened = [section for section in sections if section.first < line]
    here = opened[-1] if opened and line < opened[-1].last else None
    names = [section.values.get("name", "") for section in sections if section.kind == "Component"]
    if here is None:
        return _Place("", {}, tuple(names))
    return _Place(here.kind, here.values, tuple(names))


def _compact_names(lines: Sequence[str], first: int, typed: int) -> Iterator[str]:
    """Yield the first word of each line below the function's, but for the one that is typed."""
    number = first
    while (text := _behind_gutter(lines, number)) is not None and not _HEADER.match(text):
        if number != typed and text:
            yield text.split()[0]
        number += 1


def _compact(place: _Place, text: str, figures: Sequence[ControllerFigures]) -> Iterator[Offer]:
    """Yield what may begin a line of a component: one of the description, with its units."""
    for component, about in _described(figures):
        name = component.name
        if name not in place.components and name.startswith(text):
            yield Offer(f"{name}  := omit  ! ", f"excluded from the risk; {about}", "name", text)
            units = component.quantity or 1
            yield Offer(f"{name}  := add  1e-9  {units}  ! ", about, "name", text)


def _behind_gutter(lines: Sequence[str], number: int) -> str | None:
    """Return what a line states behind the gutter; `None` where it has no gutter."""
    matched = _LINE.fullmatch(lines[number]) if 0 <= number < len(lines) else None
    return None if matched is None else matched["text"].strip()


def _whole_block(functions: Sequence[str], gutter: str, typed: str) -> Iterator[Offer]:
    """Yield the block that is given to a function by hand."""
    indent = gutter[: len(gutter) - len(gutter.lstrip())]
    name = functions[0] if functions else "FUNCTION"
    rows = (
        HEADER,
        "@Function := {",
        f"  name = {name}",
        "  callSequence = 1",
        "}",
        "@Component := {",
        "  name = COMPONENT",
        "  probability = 1e-9",
        "  quantity = 1",
        "  redundancy = false",
        "}",
    )
    text = f"\n{indent}{GUTTER}".join(rows)
    yield Offer(text, "a block that is given by hand", "section", typed)


def _values(
    place: _Place,
    key: str,
    typed: str,
    figures: Sequence[ControllerFigures],
    functions: Sequence[str],
) -> Iterator[Offer]:
    if "!" in typed:
        return
    if key == "redundancy":
        for text, about in _REDUNDANCIES.items():
            yield Offer(text, about, "value", typed)
    elif key == NEXT.key:
        # The block that is typed in cannot be read; the last run has its function too.
        known = dict.fromkeys(
            name for figure in figures for name in (*figure.names.values(), *figure.ran)
        )
        for name in (*known, DONE):
            about = "the mission ends" if name == DONE else "a function of the model"
            yield Offer(f"{name} 1", about, "name", typed)
    elif key == "name" and place.section == "Function":
        for name in functions:
            yield Offer(name, "a function of this file", "name", typed)
    elif key == "name":
        for component, about in _described(figures):
            if component.name not in place.components:
                yield Offer(component.name, about, "name", typed)
    elif key == "quantity":
        of = place.values.get("name")
        for component, about in _described(figures):
            if component.name == of and component.quantity is not None:
                yield Offer(str(component.quantity), about, "value", typed)


def _described(figures: Sequence[ControllerFigures]) -> Iterator[tuple[Component, str]]:
    """Yield the components of the controllers' hardware descriptions, with words on each."""
    seen = set()
    for figure in figures:
        hardware = hardware_of(figure)
        for component in () if hardware is None else hardware.components:
            if component.name not in seen:
                seen.add(component.name)
                yield component, component_words(component, hardware)


def component_words(component: Component, hardware: Hardware | None) -> str:
    """Return what a hardware description says of a component, on one line."""
    count = (
        "the number that the robot has" if component.quantity is None else f"{component.quantity}"
    )
    lines = [f"units: {count}"]
    for figure in component.figures:
        what = figure.kind.replace("_", " ")
        of = f" of {figure.stated}" if figure.stated else ""
        lines.append(f"{what} {figure.value:g} per {figure.per.value}{of}")
    source = component.source or (None if hardware is None else hardware.source)
    return "; ".join([*lines, *([f"source: {source}"] if source else [])])


def hardware_of(figures: ControllerFigures) -> Hardware | None:
    """Return the hardware description of a controller's last run; `None` where it has none."""
    controller = figures.controller
    robot = figures.summary.get("robot")
    try:
        entry = controller.project.lock.controllers.get(controller.file)
        settings = controller.settings
        if entry is not None:
            recorded = RunInputs.from_data(entry.inputs)
            settings = settings.with_options(given_options(recorded, controller))
        path = None if settings.hardware is None else Path(settings.hardware)
        files = () if path is None else sysml_files(path)
        version = max((file.stat().st_mtime_ns for file in files), default=0)
    except (TraceRiskError, OSError):
        return None
    return _read(settings.hardware, settings.system, str(robot or ""), version)


@lru_cache(maxsize=16)
def _read(hardware: str | None, system: str | None, robot: str, version: int) -> Hardware | None:
    """Return a description, read once for each `version` of its files."""
    del version
    try:
        return load_hardware(Settings(hardware=hardware, system=system), robot)
    except TraceRiskError:
        return None
