"""The conditional hazard of a unit that ages: Weibull, given that it lived to its age.

The cumulative hazard of a Weibull life is H(t) = (t/scale)^shape, so a unit of age a fails within
the next t of use with 1 - exp(-(H(a+t) - H(a))): docs/theory.md#ageing.
"""

from __future__ import annotations

import math

from tracerisk.common.hardware.model import FailureFigure


def ageing_hazard(figure: FailureFigure, age_s: float, use_s: float) -> float:
    """Return H(age + use) - H(age) of a figure of kind `weibull`; times in [s].

    No digits are lost where the mission is short against the age.
    """
    span = figure.per.seconds
    assert span is not None, "a life is a time"
    scale_s = figure.value * span
    if use_s == 0.0:
        return 0.0
    try:
        if use_s < age_s:
            before = math.pow(age_s / scale_s, figure.shape)
            return before * math.expm1(figure.shape * math.log1p(use_s / age_s))
        after = math.pow((age_s + use_s) / scale_s, figure.shape)
        return after - math.pow(age_s / scale_s, figure.shape)
    except OverflowError:
        return math.inf


def mean_ageing_rate(figure: FailureFigure, age_s: float, use_s: float) -> float:
    """Return the mean hazard rate over the next `use_s` of use [1/s]; 0 without any use."""
    return ageing_hazard(figure, age_s, use_s) / use_s if use_s > 0.0 else 0.0
