"""The one unit probability that a block holds for units that differ, over several visits.

Own derivation: docs/theory.md#groups.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from tracerisk.hardware.probability import survival_log
from tracerisk.hardware.redundancy import Detection


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
        total = math.fsum(survival_log(p) for units in visits for p in units)
        return -math.expm1(total / (len(visits) * quantity))
    if detected == "each_visit":
        group = math.fsum(survival_log(math.prod(units)) for units in visits)
        return float((-math.expm1(group / len(visits))) ** (1.0 / quantity))
    failed = [-math.expm1(math.fsum(map(survival_log, unit))) for unit in zip(*visits, strict=True)]
    if 0.0 in failed:
        return 0.0
    mean = math.exp(math.fsum(map(math.log, failed)) / quantity)
    return -math.expm1(survival_log(min(mean, 1.0)) / len(visits))
