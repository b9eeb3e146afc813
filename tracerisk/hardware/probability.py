"""From a component's figures and its use to a failure probability.

Formulas: a failure probability p over a time T is that of a constant hazard, so over a time t
it is 1 - (1 - p)^(t/T); n independent demands fail with 1 - (1 - p)^n; independent causes of one
unit combine as 1 - prod(1 - p_i) (standard reliability theory, e.g. IEC 61078; written with
expm1 and log1p so that 1e-20 keeps its digits).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tracerisk.hardware.model import Basis, FailureFigure
from tracerisk.hardware.redundancy import Detection


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


def group_unit_probability(
    visits: Sequence[Sequence[float]],
    *,
    quantity: int,
    redundancy: bool,
    detected: Detection = "mission_start",
) -> float:
    """Return the one unit probability that stands for unequal units over several visits.

    visits: for each visit the failure probability of each of the `quantity` units.
    Without redundancy it is the p with 1-(1-p)^(nq) = 1-prod(1-p_vi), so OR gates of it over all
    visits give the same result. With redundancy, and failures that stay hidden, it is the p with
    (1-(1-p)^n)^q = prod_i (1-prod_v (1-p_vi)), what is failed after all visits; of a group that is
    whole again at each visit the p whose group probability p^q, over n visits, gives the same as
    the groups prod_i p_vi (own derivation, docs/theory.md#groups).
    """
    if not redundancy:
        total = math.fsum(_survival_log(p) for units in visits for p in units)
        return -math.expm1(total / (len(visits) * quantity))
    if detected == "each_visit":
        group = math.fsum(_survival_log(math.prod(units)) for units in visits)
        return float((-math.expm1(group / len(visits))) ** (1.0 / quantity))
    failed = [
        -math.expm1(math.fsum(map(_survival_log, unit))) for unit in zip(*visits, strict=True)
    ]
    if 0.0 in failed:
        return 0.0
    mean = math.exp(math.fsum(map(math.log, failed)) / quantity)
    return -math.expm1(_survival_log(min(mean, 1.0)) / len(visits))


def _hazard(figure: FailureFigure, use: Use) -> float:
    if figure.per is Basis.VISIT:
        return -_survival_log(figure.value)
    if figure.per is Basis.DEMAND:
        if use.demands is None:
            raise ValueError("the number of demands is not known")
        return 0.0 if use.demands == 0 else -use.demands * _survival_log(figure.value)
    span = figure.per.seconds
    assert span is not None
    if use.exposure_s is None:
        raise ValueError("the exposure is not known")
    if use.exposure_s == 0.0:
        return 0.0
    per_span = figure.value if figure.kind == "failure_rate" else -_survival_log(figure.value)
    return use.exposure_s / span * per_span


def _survival_log(p_failure: float) -> float:
    return -math.inf if p_failure >= 1.0 else math.log1p(-p_failure)
