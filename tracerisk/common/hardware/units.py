"""The units of failure rates and of times, and what they are in the units of the model."""

from __future__ import annotations

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
