"""How often something happens, in words."""

from __future__ import annotations

import math


def one_in(probability: float) -> str:
    """Return a probability as one in so many, in words; empty where that says nothing."""
    if not 0.0 < probability < 0.5:
        return ""
    times = 1.0 / probability
    if times >= 1e15:
        return f"one in {times:.2e}"
    digits = max(0, math.floor(math.log10(times)) - 2)
    return f"one in {round(times, -digits):,.0f}"
