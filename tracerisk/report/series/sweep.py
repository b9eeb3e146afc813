"""The points of a sweep as a table, as CSV and as a drawing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.report.tables import csv_of, rendered, share_text, table_of

_WIDTH, _HEIGHT = 640.0, 360.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 84.0, 20.0, 24.0, 56.0
_COLOURS = ("#1f4fa3", "#b3541e", "#2f7d4f", "#7a3b8f", "#8a6d1f", "#35788a", "#a33a5a", "#555555")
_FEW = 40
"""Of more values the dots are smaller, so that they stand apart."""
_LETTER = 7.3
"""The width of a letter [px]."""
_FONT = {"font-family": "monospace", "font-size": "12"}


@dataclass(frozen=True, slots=True)
class SweepPoint:
    """One point of a sweep."""

    values: Mapping[str, Any]
    """Value of each factor by name."""
    failure_probability: float | None = None
    """That of the mission; `None` where the run gave none."""
    verdict: str = ""
    """How far the run can be taken: `complete`, `partial`, `faulted`, `stuck`; empty for none."""
    simulated_s: float | None = None
    """How long the run lasted [s]."""
    leading: str = ""
    """The component with the greatest share."""
    share: float = 0.0
    """Its share, the Fussell-Vesely importance."""
    error: str = ""
    """Why there is no figure."""


def render_points(points: Sequence[SweepPoint], paper: Paper = PAPER) -> str:
    """Return the points as a table for a terminal."""
    table = table_of("Probability that a hardware failure ends the mission")
    names = list(points[0].values) if points else []
    for name in names:
        table.add_column(name, justify="right", overflow="fold")
    for heading, justify in (("p failure", "right"), ("verdict", "left"), ("run s", "right")):
        table.add_column(heading, justify=justify)  # type: ignore[arg-type]
    table.add_column("most through", overflow="fold")
    for point in points:
        p = point.failure_probability
        most = point.error or f"{point.leading} {share_text(point.share)}"
        table.add_row(
            *(str(point.values[name]) for name in names),
            "none" if p is None else f"{p:.3e}",
            point.verdict or "none",
            "" if point.simulated_s is None else f"{point.simulated_s:.1f}",
            most,
        )
    return rendered(lambda console: console.print(table), paper)


def csv_text(points: Sequence[SweepPoint]) -> str:
    """Return the points as CSV."""
    names = list(points[0].values) if points else []
    headings = (
        *names,
        "failure_probability",
        "verdict",
        "simulated_s",
        "leading",
        "share",
        "error",
    )
    rows = []
    for point in points:
        p = "" if point.failure_probability is None else repr(point.failure_probability)
        seconds = "" if point.simulated_s is None else repr(point.simulated_s)
        row = [p, point.verdict, seconds, point.leading, repr(point.share), point.error]
        rows.append([*(point.values[name] for name in names), *row])
    return csv_of(headings, rows)


def plot_svg(points: Sequence[SweepPoint]) -> str:
    """Return a drawing: the figure over the first factor, a line for each value of the others.

    Figures that span more than a factor of ten have a logarithmic axis.
    """
    root = Element(
        "svg",
        {
            "xmlns": "http://www.w3.org/2000/svg",
            "viewBox": f"0 0 {_WIDTH:g} {_HEIGHT:g}",
            "width": f"{_WIDTH:g}",
            "height": f"{_HEIGHT:g}",
            "role": "img",
        },
    )
    SubElement(root, "title").text = "Probability that a hardware failure ends the mission"
    SubElement(root, "rect", {"width": "100%", "height": "100%", "fill": "white"})
    shown = [point for point in points if point.failure_probability]
    if not shown:
        _text(root, _WIDTH / 2, _HEIGHT / 2, "no point has a figure", "middle")
        return _written(root)
    first, *others = list(shown[0].values)
    xs = list(dict.fromkeys(sweep_point.values[first] for sweep_point in shown))
    figures = [sweep_point.failure_probability or 0.0 for sweep_point in shown]
    axis = _Axis(min(figures), max(figures))
    _axes(root, first, xs, axis)
    radius = "4" if len(xs) <= _FEW else "2"
    lines: dict[str, list[SweepPoint]] = {}
    for sweep_point in shown:
        label = ", ".join(f"{name} {sweep_point.values[name]}" for name in others)
        lines.setdefault(label, []).append(sweep_point)
    for number, (label, line) in enumerate(lines.items()):
        colour = _COLOURS[number % len(_COLOURS)]
        places = [
            (_x(xs, sweep_point.values[first]), axis.y(sweep_point.failure_probability or 0.0))
            for sweep_point in line
        ]
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        SubElement(root, "polyline", {"points": way, "fill": "none", "stroke": colour})
        for (x, y), sweep_point in zip(places, line, strict=True):
            # A run that cannot be taken for the mission is hollow.
            fill = "white" if sweep_point.verdict in ("faulted", "stuck") else colour
            SubElement(
                root,
                "circle",
                {"cx": f"{x:.1f}", "cy": f"{y:.1f}", "r": radius, "fill": fill, "stroke": colour},
            )
        if label:
            _text(root, _LEFT + 8, _TOP + 14 * (number + 1), label, "start", colour)
    return _written(root)


class _Axis:
    """Places figures between the bottom and the top of the drawing."""

    def __init__(self, least: float, most: float) -> None:
        self.is_log = most > 10.0 * least
        if self.is_log:
            self.low = 10.0 ** math.floor(math.log10(least))
            self.high = 10.0 ** math.ceil(math.log10(most))
        else:
            pad = 0.1 * (most - least) or 0.1 * most
            self.low, self.high = max(0.0, least - pad), most + pad

    def y(self, value: float) -> float:
        low, high = self.low, self.high
        if self.is_log:
            low, high, value = math.log10(low), math.log10(high), math.log10(value)
        share = (value - low) / (high - low) if high > low else 0.5
        return _HEIGHT - _BOTTOM - share * (_HEIGHT - _BOTTOM - _TOP)

    def ticks(self) -> list[float]:
        if not self.is_log:
            return [self.low + (self.high - self.low) * i / 4 for i in range(5)]
        first, last = round(math.log10(self.low)), round(math.log10(self.high))
        return [10.0**power for power in range(first, last + 1)]


def _axes(root: Element, name: str, xs: Sequence[Any], axis: _Axis) -> None:
    bottom, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    way = f"M{_LEFT:g} {_TOP:g} V{bottom:g} H{right:g}"
    SubElement(root, "path", {"d": way, "fill": "none", "stroke": "#222"})
    _text(root, _LEFT, _TOP - 10, "mission failure", "middle")
    for value in axis.ticks():
        y = axis.y(value)
        way = f"M{_LEFT:g} {y:.1f} H{right:g}"
        SubElement(root, "path", {"d": way, "fill": "none", "stroke": "#ddd"})
        _text(root, _LEFT - 8, y + 4, f"{value:.3g}", "end")
    # As many labels as have room beside each other.
    label = _LETTER * max(len(str(item)) for item in xs) + 12.0
    step = max(1, math.ceil(len(xs) * label / (right - _LEFT)))
    for value in xs[::step]:
        # A wide label at the right end stays within the picture.
        room = _WIDTH - 4.0 - _LETTER * len(str(value)) / 2
        _text(root, min(_x(xs, value), room), bottom + 18, str(value), "middle")
    _text(root, (_LEFT + right) / 2, bottom + 40, name, "middle")


def _x(xs: Sequence[Any], value: Any) -> float:
    """Return where a value stands: numbers by their size, others in their order."""
    span = _WIDTH - _RIGHT - _LEFT - 40.0
    numbers = [x for x in xs if isinstance(x, int | float) and not isinstance(x, bool)]
    if len(numbers) == len(xs) > 1 and isinstance(value, int | float):
        low, high = min(numbers), max(numbers)
        return _LEFT + 20.0 + span * (value - low) / (high - low)
    return _LEFT + 20.0 + span * xs.index(value) / max(1, len(xs) - 1)


def _text(root: Element, x: float, y: float, text: str, anchor: str, colour: str = "#222") -> None:
    place = {"x": f"{x:.1f}", "y": f"{y:.1f}", "text-anchor": anchor}
    SubElement(root, "text", {**place, **_FONT, "fill": colour}).text = text


def _written(root: Element) -> str:
    return tostring(root, encoding="unicode") + "\n"
