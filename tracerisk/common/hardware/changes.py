"""How two hardware descriptions differ, component by component, in words with their sources."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tracerisk.common.hardware.description_data import component_data
from tracerisk.common.hardware.model import Component, FailureFigure, Hardware

_PER = {"minute": "/min", "hour": "/h"}
_FIGURES = ("probability", "failure_rate", "weibull", "standby_rate")


def description_changes(before: Hardware, after: Hardware) -> tuple[str, ...]:
    """Return what differs between two descriptions, a line for each value, by component.

    A figure has its source: its own, else that of its component or description.
    """
    old = {component.name: component for component in before.components}
    new = {component.name: component for component in after.components}
    lines = []
    for name in dict.fromkeys([*new, *old]):
        if name not in old:
            lines.append(f"{name} is new: {_all_figures(new[name], after)}")
        elif name not in new:
            lines.append(f"{name} is gone: {_all_figures(old[name], before)}")
        else:
            values = _values(old[name], before), _values(new[name], after)
            lines += [f"{name}: {line}" for line in _changed(*values)]
    return tuple(lines)


def _changed(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    for key in dict.fromkeys([*new, *old]):
        if old.get(key) != new.get(key):
            yield f"{key} {old.get(key, 'not given')} -> {new.get(key, 'not given')}"


def _values(component: Component, hardware: Hardware) -> dict[str, str]:
    """Return what is said of a component, each value as text by its dotted key."""
    figures: dict[str, list[str]] = {}
    for figure in component.figures:
        figures.setdefault(_key(figure), []).append(_text(figure, component, hardware))
    usual = {"quantity": "*" if component.quantity is None else component.quantity}
    if not component.redundancy:
        usual["redundancy"] = "false"
    data = {**usual, **component_data(component)}
    others = {key: value for key, value in data.items() if key not in (*_FIGURES, "source")}
    return {key: ", ".join(texts) for key, texts in figures.items()} | dict(_flat(others, ""))


def _flat(value: Any, path: str) -> Iterator[tuple[str, str]]:
    if not isinstance(value, dict):
        yield path, str(value).lower() if isinstance(value, bool) else str(value)
        return
    for key, part in value.items():
        yield from _flat(part, f"{path}.{key}" if path else key)


def _all_figures(component: Component, hardware: Hardware) -> str:
    return ", ".join(
        f"{_key(figure)} {_text(figure, component, hardware)}" for figure in component.figures
    )


def _key(figure: FailureFigure) -> str:
    return "standby_rate" if figure.standby else figure.kind


def _text(figure: FailureFigure, component: Component, hardware: Hardware) -> str:
    """Return a figure with its unit, its uncertainty and its source: `2e-07/h (IEC 61709)`."""
    per = _PER.get(figure.per.value, f" per {figure.demand or figure.per.value}")
    text = f"{figure.value:.6g}{per}"
    if figure.kind == "weibull":
        text = f"shape {figure.shape:.6g}, scale {figure.value:.6g} {figure.per.value}s"
    if figure.error_factor is not None:
        text += f", error factor {figure.error_factor:.6g}"
    source = figure.source or component.source or hardware.source or "no source"
    return f"{text} ({source})"
