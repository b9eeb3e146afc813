"""The published text format of a run's log: functions, their active components, call sequence.

    Function:pick()
    ActiveComponents:gripper,electric_motor

    CallSequence:pick(),place()

Source: Grimmeisen, Golwalkar, Ma, Morozov, "Automated and Continuous Risk Assessment for
ROS-Based Software-Defined Robotic Systems" (2024), listing 1. It lists which components were
active and not for how long.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location, LogError, one_of
from tracerisk.trace import Element, RunEnd, Trace, TracedFunction, Visit

_FUNCTION = "Function:"
_COMPONENTS = "ActiveComponents:"
_SEQUENCE = "CallSequence:"
_CALL = re.compile(r"([^\s(),]+(?: \([^(),]+\))?)\(\)")
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


def _parse(text: str, file: str) -> tuple[dict[str, list[str]], list[tuple[str, int]]]:
    active: dict[str, list[str]] = {}
    calls: list[tuple[str, int]] = []
    current: str | None = None
    for number, raw in enumerate(text.splitlines(), start=1):
        line, place = raw.strip(), Location(file, number)
        if line.startswith(_FUNCTION):
            (current,) = _names(line.removeprefix(_FUNCTION), _CALL, place, just_one=True)
            if current in active:
                raise LogError(f"{current}() is listed twice", place)
            active[current] = []
        elif line.startswith(_COMPONENTS):
            if current is None:
                raise LogError(
                    "components without a function; write a 'Function:name()' line first", place
                )
            active[current] = _names(line.removeprefix(_COMPONENTS), _COMPONENT, place)
            current = None
        elif line.startswith(_SEQUENCE):
            if calls:
                raise LogError("duplicate call sequence; a log has one", place)
            named = _names(line.removeprefix(_SEQUENCE), _CALL, place)
            calls = [(name, number) for name in named]
        elif line:
            raise LogError(
                f"unknown line {line[:40]!r}; {one_of([_FUNCTION, _COMPONENTS, _SEQUENCE])}", place
            )
    if not calls:
        raise LogError("has no 'CallSequence:' line with a call", Location(file))
    return active, calls


def _names(
    text: str, pattern: re.Pattern[str], place: Location, *, just_one: bool = False
) -> list[str]:
    names = []
    for part in text.split(",") if text.strip() else []:
        matched = pattern.fullmatch(part.strip())
        if matched is None:
            example = "init()" if pattern is _CALL else "electric_motor"
            raise LogError(f"{part.strip()!r} is not a name such as {example}", place)
        names.append(matched[1] if pattern is _CALL else matched[0])
    if just_one and len(names) != 1:
        raise LogError(f"expected one function, found {len(names)}", place)
    if len(set(names)) != len(names) and pattern is _COMPONENT:
        raise LogError("has a duplicate component", place)
    return names
