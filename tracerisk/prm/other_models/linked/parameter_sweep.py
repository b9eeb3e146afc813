"""What if a parameter of a linked model were another: its figures along a range."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracerisk.prm.other_models.linked.model import LinkedModel


@dataclass(frozen=True, slots=True)
class FigurePoint:
    """Every figure of the model with the swept parameter at `value`."""

    value: float
    figures: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class FigureSweep:
    """A parameter swept over a range; `before` is its value in the model."""

    name: str
    before: float
    points: tuple[FigurePoint, ...]


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
