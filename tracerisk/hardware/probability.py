"""From a component's figures and its use to a failure probability.

Formulas: a failure probability p over a time T is that of a constant hazard, so over a time t
it is 1 - (1 - p)^(t/T); n independent demands fail with 1 - (1 - p)^n; independent causes of one
unit combine as 1 - prod(1 - p_i) (standard reliability theory, e.g. IEC 61078; written with
expm1 and log1p so that 1e-20 keeps its digits).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from tracerisk.hardware.model import Basis, FailureFigure


@dataclass(frozen=True, slots=True)
class Use:
    """What one unit did during one visit: exposure [s] and number of demands.

    `exposure_s` and `demands` are `None` where the source of the trace does not tell them.
    """

    exposure_s: float | None
    demands: int | None


def figure_probability(figure: FailureFigure, use: Use) -> float:
    """Return the failure probability of one unit during one visit, by one of its figures.

    Raises ValueError when the figure needs an exposure or a count that `use` does not hold.
    """
    return -math.expm1(-_hazard(figure, use))


def unit_probability(figures: Iterable[FailureFigure], use: Use) -> float:
    """Return the failure probability of one unit during one visit, all its figures together."""
    return -math.expm1(-math.fsum(_hazard(figure, use) for figure in figures))


def _hazard(figure: FailureFigure, use: Use) -> float:
    if figure.per is Basis.VISIT:
        return -survival_log(figure.value)
    if figure.per is Basis.DEMAND:
        if use.demands is None:
            raise ValueError("the number of demands is not known")
        return 0.0 if use.demands == 0 else -use.demands * survival_log(figure.value)
    span = figure.per.seconds
    assert span is not None
    if use.exposure_s is None:
        raise ValueError("the exposure is not known")
    if use.exposure_s == 0.0:
        return 0.0
    per_span = figure.value if figure.kind == "failure_rate" else -survival_log(figure.value)
    return use.exposure_s / span * per_span


def survival_log(p_failure: float) -> float:
    """Return ln(1 - p), minus infinity for certain failure."""
    return -math.inf if p_failure >= 1.0 else math.log1p(-p_failure)
