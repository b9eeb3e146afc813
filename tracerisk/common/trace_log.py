"""The published text format of a run's log: functions, their active components, call sequence.

    Function:pick()
    ActiveComponents:gripper,electric_motor

    CallSequence:pick(),place()

Source: Grimmeisen, Golwalkar, Ma, Morozov, "Automated and Continuous Risk Assessment for
ROS-Based Software-Defined Robotic Systems" (2024), listing 1. It lists which components were
active and not for how long. A list may wrap at its commas, as it does in print.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.traced.elements import Element
from tracerisk.errors import Location, LogError, one_of
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

_FUNCTION = "Function:"
_COMPONENTS = "ActiveComponents:"
_SEQUENCE = "CallSequence:"
_HEAD = re.compile(r"(Function|ActiveComponents|CallSequence)\s*:(?!:)")
_CALL = re.compile(r"([^\s(),]+(?: \([^(),]+\))?)\s*\(\s*\)")
_COMPONENT = re.compile(r"[^\s(),:]+")


def write_log(active: Mapping[QualifiedName, Sequence[str]]) -> str:
    """Return the log of functions, in the order of their call sequence, with their components."""
    lines = []
    for name, components in active.items():
        lines += [f"{_FUNCTION}{name}()", f"{_COMPONENTS}{','.join(components)}"]
    sequence = ",".join(f"{name}()" for name in active)
    return "\n".join([*lines, "", f"{_SEQUENCE}{sequence}"]) + "\n"


def read_log(text: str, file: str, *, controller: str) -> Trace:
    """Read a published log as the trace of `controller`.

    Each entry of the call sequence is one visit; its elements are components, whose exposure
    the log does not hold.
    Raises LogError with file and line when a line is unknown, a function is listed twice,
    called and not listed or listed and not called, or the call sequence is missing.
    """
    active, calls = _parse(text, file)
    names = list(dict.fromkeys(name for name, _ in calls))
    for name, line in calls:
        if name not in active:
            raise LogError(
                f"{name}() is called but has no 'Function:{name}()' line; {one_of(active, name)}",
                Location(file, line),
            )
    for name in active:
        if name not in names:
            raise LogError(
                f"{name}() is listed but not in the call sequence", Location(file, calls[0][1])
            )
    refs = {name: FunctionRef(controller, QualifiedName(name)) for name in names}
    visits = tuple(
        Visit(
            function=refs[name],
            start_s=float(number),
            duration_s=None,
            outcome="succeeded",
            exposures=dict.fromkeys(active[name]),
        )
        for number, (name, _) in enumerate(calls)
    )
    elements = dict.fromkeys(component for texts in active.values() for component in texts)
    return Trace(
        controller=controller,
        robot="",
        scene="",
        end=RunEnd("ended", f"read from the log {file}", None),
        elements=tuple(Element(name, "component") for name in elements),
        functions=tuple(
            TracedFunction(refs[name], 0, rank) for rank, name in enumerate(names, start=1)
        ),
        visits=visits,
    )


class _Line(NamedTuple):
    """A line of a log, with those onto which its list wraps."""

    head: str
    """What the line lists: `Function:`, `ActiveComponents:` or `CallSequence:`."""
    text: str
    """The list, with its line breaks."""
    number: int
    """Number of the first line, from 1."""


def _lines(text: str, file: str) -> list[_Line]:
    """Return the lines of a log; raise LogError at one that neither begins nor continues a list."""
    lines: list[_Line] = []
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.strip()
        matched = _HEAD.match(line)
        if matched is not None:
            lines.append(_Line(f"{matched[1]}:", line[matched.end() :], number))
        elif lines and (not line or _goes_on(lines[-1].text, line)):
            lines[-1] = lines[-1]._replace(text=f"{lines[-1].text}\n{line}")
        elif line:
            raise LogError(
                f"unknown line {line[:40]!r}; {one_of([_FUNCTION, _COMPONENTS, _SEQUENCE])}",
                Location(file, number),
            )
    return lines


def _goes_on(before: str, line: str) -> bool:
    """Whether a line continues a list: the list wraps at a comma, or behind its colon."""
    return line.startswith(",") or before.rstrip().endswith(",") or not before.strip()


def _parse(text: str, file: str) -> tuple[dict[str, list[str]], list[tuple[str, int]]]:
    active: dict[str, list[str]] = {}
    calls: list[tuple[str, int]] = []
    current: str | None = None
    for line in _lines(text, file):
        place = Location(file, line.number)
        if line.head == _FUNCTION:
            named = _names(line, _CALL, file)
            if len(named) != 1:
                raise LogError(f"expected one function, found {len(named)}", place)
            current = named[0][0]
            if current in active:
                raise LogError(f"{current}() is listed twice", place)
            active[current] = []
        elif line.head == _COMPONENTS:
            if current is None:
                raise LogError(
                    "components without a function; write a 'Function:name()' line first", place
                )
            active[current] = [name for name, _ in _names(line, _COMPONENT, file)]
            if len(set(active[current])) != len(active[current]):
                raise LogError("has a duplicate component", place)
            current = None
        else:
            if calls:
                raise LogError("duplicate call sequence; a log has one", place)
            calls = _names(line, _CALL, file)
    if not calls:
        raise LogError("has no 'CallSequence:' line with a call", Location(file))
    return active, calls


def _names(line: _Line, pattern: re.Pattern[str], file: str) -> list[tuple[str, int]]:
    """Return the names in a list, each with the number of its line."""
    names = []
    number = line.number
    for part in line.text.split(",") if line.text.strip() else []:
        at = number + part[: len(part) - len(part.lstrip())].count("\n")
        matched = pattern.fullmatch(part.strip())
        if matched is None:
            example = "init()" if pattern is _CALL else "electric_motor"
            raise LogError(f"{part.strip()!r} is not a name such as {example}", Location(file, at))
        names.append((matched[1] if pattern is _CALL else matched[0], at))
        number += part.count("\n")
    return names
