"""How two hardware descriptions differ, component by component, in words with their sources."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

from tracerisk.common.hardware.description_data import component_data
from tracerisk.common.hardware.model import FIGURE_KEYS, Component, FailureFigure, Hardware

_PER = {"minute": "/min", "hour": "/h"}
_Sourced = tuple[FailureFigure, str]
"""A figure with the source that counts for it."""
_Value = str | tuple[str, ...]
"""Another value of a component as text, or the names of a list."""


def description_changes(before: Hardware, after: Hardware) -> tuple[str, ...]:
    """Return what differs between two descriptions, a line for each value, by component.

    A figure has its source: its own, else that of its component or description. One that became
    another kind of figure, or one per another unit of time, is one line with one unit. Places are
    those of the later description.
    """
    old = {component.name: component for component in before.components}
    new = {component.name: component for component in after.components}
    lines = []
    for name in dict.fromkeys([*new, *old]):
        if name not in old:
            lines.append(f"{_placed(new[name])} is new: {_all_figures(new[name], after)}")
        elif name not in new:
            lines.append(f"{name} is gone: {_all_figures(old[name], before)}")
        else:
            changes = [
                *_changed_figures((old[name], before), (new[name], after)),
                *_changed_values(*_beside_figures(old[name], new[name])),
            ]
            lines += [f"{_placed(new[name])}: {line}" for line in changes]
    return tuple(lines)


def figure_ratios(before: Hardware, after: Hardware) -> dict[str, float]:
    """Return the ratio of later to earlier figures of each component, where it is one for all.

    Components that differ in anything else but sources are left out, and so are those with wear-out
    by Weibull, whose figure is no rate.
    """
    old = {component.name: component for component in before.components}
    ratios = {}
    for component in after.components:
        earlier = old.get(component.name)
        if earlier is None or len(earlier.figures) != len(component.figures):
            continue
        pairs = list(zip(earlier.figures, component.figures, strict=True))
        same = replace(component, figures=earlier.figures, source=earlier.source)
        if same != earlier or not all(_is_rate(was, now) for was, now in pairs):
            continue
        first = pairs[0][1].value / pairs[0][0].value
        is_one = all(math.isclose(now.value, first * was.value) for was, now in pairs)
        if is_one and first != 1.0:
            ratios[component.name] = first
    return ratios


def _is_rate(was: FailureFigure, now: FailureFigure) -> bool:
    """Return whether two figures are of one kind, and a failure grows with their value alone."""
    kinds = [(one.kind, one.per, one.standby, one.demand) for one in (was, now)]
    return kinds[0] == kinds[1] and was.kind != "weibull" and was.value > 0.0 < now.value


def moved_units(before: Hardware, after: Hardware) -> dict[str, tuple[str, ...]]:
    """Return the components of `after` alone whose units are no longer those of other components.

    For each the components that had all of its units in `before`. A joint that is described apart
    was counted before.
    """
    known = {component.name for component in before.components}
    left = {component.name: _units(component) for component in after.components}
    moved: dict[str, tuple[str, ...]] = {}
    for component in after.components:
        units = _units(component)
        if component.name in known or not units:
            continue
        sources: dict[str, set[str]] = {}
        for other in before.components:
            had = _covered(units, _units(other))
            given_up = had - _covered(units, left.get(other.name, set()))
            if given_up:
                sources[other.name] = given_up
        if set().union(*sources.values()) == units:
            moved[component.name] = tuple(sources)
    return moved


def _units(component: Component) -> set[str]:
    """Return the elements of the twin that are units of a component; `joint *` is all joints."""
    twin = component.twin
    if twin is None:
        return set()
    sensors = (f"all {twin.sensors}",) if isinstance(twin.sensors, str) else twin.sensors
    return {
        *(f"joint {name}" for name in twin.joints),
        *(f"actuator {name}" for name in twin.actuators),
        *(f"sensor {name}" for name in sensors),
        *(["gripper"] if twin.gripper else []),
    }


def _covered(units: set[str], other: set[str]) -> set[str]:
    """Return which units another component has as well."""
    is_all = "joint *" in other
    return {unit for unit in units if unit in other or (is_all and unit.startswith("joint "))}


def _placed(component: Component) -> str:
    """Return the name of a component with its place in the description, if it has one."""
    place = component.location
    return component.name + ("" if place is None else f" ({place.file}:{place.line})")


def _changed_figures(
    before: tuple[Component, Hardware], after: tuple[Component, Hardware]
) -> Iterator[str]:
    gone, come = _figures(*before), _figures(*after)
    for key in [key for key in come if key in gone]:
        old, new = gone.pop(key), come.pop(key)
        if _texts(old) != _texts(new) and old != new:
            yield f"{key} {_from_to(old, new)}"
    if gone and come:
        old, new = (list(chain.from_iterable(kinds.values())) for kinds in (gone, come))
        yield f"{', '.join(gone)} {_texts(old, new)} -> {', '.join(come)} {_texts(new)}"
        return
    yield from (f"{key} not given -> {_texts(figures)}" for key, figures in come.items())
    yield from (f"{key} {_texts(figures)} -> not given" for key, figures in gone.items())


def _figures(component: Component, hardware: Hardware) -> dict[str, list[_Sourced]]:
    figures: dict[str, list[_Sourced]] = {}
    for figure in component.figures:
        source = figure.source or component.source or hardware.source or "no source"
        figures.setdefault(figure.key, []).append((figure, source))
    return figures


def _from_to(old: Sequence[_Sourced], new: Sequence[_Sourced]) -> str:
    """Return earlier and later figures; a source that all of them have is said once."""
    sources = {source for _, source in (*old, *new)}
    if len(sources) > 1:
        return f"{_texts(old, new)} -> {_texts(new)}"
    was, now = _texts(old, new, with_source=False), _texts(new, with_source=False)
    return f"{was} -> {now} (both: {sources.pop()})"


def _texts(
    figures: Sequence[_Sourced], others: Sequence[_Sourced] = (), *, with_source: bool = True
) -> str:
    """Return figures with their sources; a single one also in the unit of a single other one."""
    same = ""
    if len(figures) == len(others) == 1:
        same = _in_unit_of(figures[0][0], others[0][0])
    return ", ".join(
        f"{_text(figure)}{same}" + (f" ({source})" if with_source else "")
        for figure, source in figures
    )


def _in_unit_of(figure: FailureFigure, other: FailureFigure) -> str:
    """Return a figure per time as one per the time of another; empty where they need no words."""
    spans = figure.per.seconds, other.per.seconds
    if spans[0] is None or spans[1] is None or spans[0] == spans[1]:
        return ""
    if "weibull" in (figure.kind, other.kind) or figure.value >= 1.0:
        return ""
    # A probability in a time is that of a constant rate; far below 1 both are the same figure.
    rate = -math.log1p(-figure.value) if figure.kind == "probability" else figure.value
    value = rate * spans[1] / spans[0]
    if other.kind == "probability":
        value = -math.expm1(-value)
    return f" = {value:.4g}{_PER[other.per.value]}"


def _beside_figures(
    before: Component, after: Component
) -> tuple[dict[str, _Value], dict[str, _Value]]:
    """Return what is said of both beside their figures; names of all joints are their number."""
    old, new = _values(before), _values(after)
    joints = {old.get("twin.joints"), new.get("twin.joints")}
    if "*" in joints and len(joints) == 2 and "*" in (old["quantity"], new["quantity"]):
        del old["quantity"], new["quantity"]
    return old, new


def _changed_values(old: Mapping[str, _Value], new: Mapping[str, _Value]) -> Iterator[str]:
    for key in dict.fromkeys([*new, *old]):
        was, now = old.get(key, "not given"), new.get(key, "not given")
        if was == now:
            continue
        if isinstance(was, tuple) and isinstance(now, tuple):
            less = [name for name in was if name not in now]
            more = [name for name in now if name not in was]
            parts = [f"no longer {', '.join(less)}"] if less else []
            parts += [f"now also {', '.join(more)}"] if more else []
            yield f"{key} {' and '.join(parts) or 'in another order'}"
        else:
            yield f"{key} {_value_text(was)} -> {_value_text(now)}"


def _value_text(value: _Value) -> str:
    return value if isinstance(value, str) else ", ".join(value)


def _values(component: Component) -> dict[str, _Value]:
    """Return what is said of a component beside its figures, by its dotted key."""
    usual = {"quantity": "*" if component.quantity is None else component.quantity}
    if not component.redundancy:
        usual["redundancy"] = "false"
    data = {**usual, **component_data(component)}
    others = {key: value for key, value in data.items() if key not in (*FIGURE_KEYS, "source")}
    values = dict(_flat(others, ""))
    # It says no more than that a robot may lack the component, and then nothing has its figures.
    values.pop("twin.optional", None)
    return values


def _flat(value: Any, path: str) -> Iterator[tuple[str, _Value]]:
    if isinstance(value, (list, tuple)) and not any(isinstance(part, dict) for part in value):
        yield path, tuple(map(str, value))
        return
    if not isinstance(value, dict):
        yield path, str(value).lower() if isinstance(value, bool) else str(value)
        return
    for key, part in value.items():
        yield from _flat(part, f"{path}.{key}" if path else key)


def _all_figures(component: Component, hardware: Hardware) -> str:
    figures = _figures(component, hardware)
    return ", ".join(f"{key} {_texts(given)}" for key, given in figures.items())


def _text(figure: FailureFigure) -> str:
    """Return a figure with its unit and its uncertainty: `2e-07/h, error factor 3`."""
    per = _PER.get(figure.per.value, f" per {figure.demand or figure.per.value}")
    text = f"{figure.value:.6g}{per}"
    if figure.kind == "weibull":
        text = f"shape {figure.shape:.6g}, scale {figure.value:.6g} {figure.per.value}s"
    if figure.stated:
        text += f" of {figure.stated}"
    if figure.error_factor is not None:
        text += f", error factor {figure.error_factor:.6g}"
    return text
