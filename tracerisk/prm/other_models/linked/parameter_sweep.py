"""What if a parameter of a linked model were another: its figures along a range."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracerisk.prm.other_models.linked.model import LinkedModel


@dataclass(frozen=True, slots=True)
class FigurePoint:
    """One point of a sweep."""

    value: float
    """Value of the swept parameter."""
    figures: Mapping[str, float]
    """Value of every figure of the model, by name."""


@dataclass(frozen=True, slots=True)
class FigureSweep:
    """A parameter swept over a range."""

    name: str
    """Name of the parameter."""
    before: float
    """Its value in the model."""
    points: tuple[FigurePoint, ...]
    """Solutions in the order of the values."""


def sweep(
    model: LinkedModel,
    name: str,
    values: Iterable[float],
    others: Mapping[str, float] | None = None,
) -> FigureSweep:
    """Solve the model for each value of one parameter; `others` are set throughout.

    Raises ModelError as solving does.
    """
    kept = dict(others or {})
    before = model.solve(kept).parameters[model.parameter(name).name]
    points = tuple(
        FigurePoint(value, model.solve({**kept, name: value}).figures) for value in values
    )
    return FigureSweep(name, before, points)
