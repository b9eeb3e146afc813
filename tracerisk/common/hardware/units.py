"""The units of failure rates and of times, and what they are in the units of the model."""

from __future__ import annotations

import math
import re
from fractions import Fraction

SECONDS_PER = {"second": 1.0, "minute": 60.0, "hour": 3600.0}
"""The spans in which a time may be given [s]."""

_HOURS_PER_FIT = 10**9


def rate_from_fit(fit: float) -> float:
    """Return a rate in FIT, failures per 1e9 hours, as failures per hour.

    The number that the same decimal digits per hour would give: 0.57 FIT is 5.7e-10 per hour to
    the last bit, which a division by 1e9 would miss.
    """
    return float(Fraction(repr(float(fit))) / _HOURS_PER_FIT)


def mean_time_hint(name: str, value: object = None) -> str:
    """Return how a key for a mean time, as data sheets state one, is given as a figure.

    "" for any other key. `value` is what stands there, in hours if it is a number.
    """
    word = re.sub(r"[^a-z0-9]", "", name.lower())
    if word.startswith("b10"):
        return "of a B10d, give probability: {value: 0.1 / B10d, per: demand}, dangerous ones alone"
    if not word.startswith(("mtbf", "mttf")):
        return ""
    hours = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else 0.0
    if not (math.isfinite(hours) and hours > 0.0):
        hours = 886_000.0
    dangerous = ", which counts dangerous failures alone" if word.startswith("mttfd") else ""
    return (
        f"of {hours:.10g} hours{dangerous}, give the rate 1 / {hours:.10g}: "
        f"failure_rate: {{value: {1.0 / hours:.6g}, per: hour}}"
    )
