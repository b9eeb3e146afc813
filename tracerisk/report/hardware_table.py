"""A hardware description as a table for the terminal."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from textwrap import wrap

from tracerisk.adder.blocks.values import computed_redundancy
from tracerisk.common.hardware.binding import BoundComponent
from tracerisk.common.hardware.load import exponent_text
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware, TwinBinding

_TITLES = ("component", "units", "figures of one unit", "seen at", "source")
_GAP = "  "
_LEAST = 8  # columns of a cell that is broken


def hardware_table(
    hardware: Hardware,
    bound: Mapping[str, BoundComponent] | None = None,
    width: int | None = None,
) -> list[str]:
    """Return the lines of a table of the components, and the sources that it numbers.

    `bound` are the components that a robot has, by name: then quantities are those of the robot,
    and optional components that it lacks are marked. Cells go on below where a table would be
    wider than `width`.
    """
    sources: list[str] = []
    rows: list[Sequence[str]] = [_TITLES]
    for component in hardware.components:
        bound_component = None if bound is None else bound.get(component.name)
        if bound is not None and bound_component is None:
            rows.append((component.name, "0", "", "the robot has none", ""))
            continue
        quantity = component.quantity if bound_component is None else bound_component.quantity
        cells = (
            [component.name],
            list(_units(component, quantity)),
            list(figure_lines(component)),
            list(_places(component)),
            list(_source(component, hardware.source, sources)),
        )
        rows += zip_longest(*cells, fillvalue="")
    widths = _fitted([max(map(len, column)) for column in zip(*rows, strict=True)], width)
    lines = [
        _GAP.join(map(str.ljust, line, widths)).rstrip()
        for row in rows
        for line in zip_longest(*map(_broken, row, widths), fillvalue="")
    ]
    numbered = [
        line
        for number, text in enumerate(sources, start=1)
        for line in _broken(f"[{number}] {text}", width)
    ]
    return [*lines, *([""] if numbered else []), *numbered]


def _fitted(widths: list[int], width: int | None) -> list[int]:
    """Return the widths of columns side by side in `width`: names whole, the widest narrower."""
    while width is not None and sum(widths) + len(_GAP) * (len(widths) - 1) > width:
        widest = widths.index(max(widths[1:]), 1)
        if widths[widest] <= _LEAST:
            break
        widths[widest] -= 1
    return widths


def _broken(cell: str, width: int | None) -> list[str]:
    return [cell] if width is None else wrap(cell, width, subsequent_indent=" ") or [""]


def figure_text(figure: FailureFigure) -> str:
    """Return a figure with its unit, in words."""
    if figure.kind == "weibull":
        text = f"wear-out: shape {figure.shape:g}, life {figure.value:g} {figure.per.value}s"
    else:
        per = figure.demand or figure.per.value
        text = f"{figure.value:g} per {per}"
        text += " not in use" if figure.standby else ""
        text += " (rate)" if figure.kind == "failure_rate" and not figure.standby else ""
    text += f", of {figure.stated}" if figure.stated else ""
    if figure.error_factor is not None:
        text += f", error factor {figure.error_factor:g}"
        text += " (p95 / p50); the value is the mean" if figure.value_is == "mean" else ""
    return text


def _units(component: Component, quantity: int | None) -> Iterator[str]:
    """Yield how many there are, and how many of them must work."""
    if quantity is None:
        yield "as the robot has"
    number = "" if quantity is None else f"{quantity}, "
    group = component.redundancy
    if not group:
        yield "1" if component.quantity == 1 else f"{number}all needed"
        return
    words = computed_redundancy(group).text.split(", ")
    yield number + ("one suffices" if words[0] == "true" else f"{group.required} must work")
    yield from words[1:]
    if component.test_interval_s is not None:
        yield f"tested every {component.test_interval_s / 3600:g} h"
    if component.repair is not None:
        yield f"repaired in {component.repair.mean_time_s / 3600:g} h (mean)" + (
            ", within missions too" if component.repair.in_mission else ""
        )


def figure_lines(component: Component) -> Iterator[str]:
    """Yield what counts for one unit, in words: its figures, its load law, its modes."""
    for figure in component.figures:
        yield figure_text(figure)
    if component.age_s:
        yield f"age {component.age_s / Basis.HOUR.seconds:g} hours" if Basis.HOUR.seconds else ""
    if (law := component.load_law) is not None:
        speed = "" if law.reference_speed is None else f" at speed {law.reference_speed:g}"
        yield (
            f"load law: {law.wearing_share:.0%} x (load/{law.reference_load:g})^"
            f"{exponent_text(law.exponent)}{speed}"
        )
    if component.exposure_error_factor is not None:
        yield f"use: error factor {component.exposure_error_factor:g}"
    if component.lot is not None:
        yield f"lot {component.lot}"
    for mode in component.modes:
        uses = f" while {', '.join(mode.when)}" if mode.when else ""
        yield f"mode {mode.name}: {mode.fraction:.4g}{uses}"


def _places(component: Component) -> Iterator[str]:
    if component.always_active:
        yield "always in use"
    elif component.twin is None:
        yield "by its name in a log"
    else:
        yield from _binding(component.twin)


def _binding(twin: TwinBinding) -> Iterator[str]:
    if twin.joints:
        yield "every joint" if twin.joints == "*" else f"joints {_joined(twin.joints)}"
    if twin.actuators:
        yield f"actuators {_joined(twin.actuators)}"
    if twin.gripper:
        yield "gripper, if any" if twin.optional else "gripper"
    if isinstance(twin.sensors, str):
        yield f"every {twin.sensors} sensor" + (", if any" if twin.optional else "")
    elif twin.sensors:
        yield f"sensors {_joined(twin.sensors)}"
    if twin.contacts:
        yield f"contacts of {_joined(twin.contacts)}"


def _joined(names: Sequence[str]) -> str:
    """Return names in their order, those of three or more numbers in a row by first and last."""
    parts: list[str] = []
    row: list[str] = []
    for name in [*names, ""]:
        if row and name != _next(row[-1]):
            parts += row if len(row) < 3 else [f"{row[0]} to {row[-1]}"]
            row = []
        row.append(name)
    return ", ".join(parts)


def _next(name: str) -> str | None:
    """Return the name with the number after that at its end, `joint5` for `joint4`."""
    end = re.search(r"\d+$", name)
    return None if end is None else f"{name[: end.start()]}{int(end[0]) + 1}"


def _source(component: Component, default: str | None, sources: list[str]) -> Iterator[str]:
    """Yield the number of each source; `sources` takes those that are new."""
    texts = [" ".join(text.split()) for text in component.sources(default)]
    if not texts:
        yield "none"
    for text in texts:
        if text not in sources:
            sources.append(text)
        yield f"[{sources.index(text) + 1}]"
