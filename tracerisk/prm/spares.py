"""A group of units with spares, as a small Markov chain over one visit.

Source: the models of standby systems of M. Rausand, A. Hoyland, "System Reliability Theory",
2nd ed. (2004); solved by uniformisation (A. Jensen, 1953), whose terms are all positive.
"""

from __future__ import annotations

import math


def spare_group_failure(
    p: float, *, units: int, required: int, dormancy: float, switch: float
) -> float:
    """Return the probability that fewer than `required` of `units` serve during one visit.

    `p` is the failure probability of a working unit over the visit. A spare fails at `dormancy`
    times the rate of a working unit: 0 of a cold spare, 1 of a hot one. When a working unit
    fails a spare takes over, but for the probability `switch`, with which the group fails.
    Relative error below 1e-12, for rare failures too.
    Raises ValueError for figures outside their ranges.
    """
    if not 1 <= required <= units or not all(0.0 <= x <= 1.0 for x in (p, dormancy, switch)):
        raise ValueError("required from 1 to units, and shares and probabilities from 0 to 1")
    if p in (0.0, 1.0):
        # Without failures nothing happens; a unit that fails at once takes every spare with it.
        return p
    rate = -math.log1p(-p)
    spares = units - required
    working = [required * rate] * (spares + 1)
    dormant = [(spares - lost) * dormancy * rate for lost in range(spares + 1)]
    fastest = max(one + other for one, other in zip(working, dormant, strict=True))
    # The chance of each number of lost units, and of a failed group, after so many events.
    chance = [1.0] + [0.0] * spares
    failed = 0.0
    weight, total, count = math.exp(-fastest), 0.0, 0
    while True:
        total += weight * failed
        # Past its peak what is left of the series is below the next weight times a small factor.
        if count > fastest + spares + 1 and weight <= 1e-18 * total:
            return min(total, 1.0)
        following = [0.0] * (spares + 1)
        for lost, now in enumerate(chance):
            take_over = working[lost] * (1.0 - switch) + dormant[lost]
            break_down = working[lost] * switch
            if lost == spares:
                take_over, break_down = 0.0, working[lost]
            else:
                following[lost + 1] += now * take_over / fastest
            failed += now * break_down / fastest
            following[lost] += now * (1.0 - (take_over + break_down) / fastest)
        chance = following
        count += 1
        weight *= fastest / count
