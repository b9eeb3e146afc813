"""A group of like units with spares, as a small Markov chain over one visit.

Source: the models of standby systems of M. Rausand, A. Hoyland, "System Reliability Theory",
2nd ed. (2004). Groups of unlike units, and spares that several groups share, are in
`tracerisk.prm.dynamic`.
"""

from __future__ import annotations

import math

from tracerisk.prm.trees.failure_chain import FailureChain


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
    working = required * rate
    spares = units - required
    # State 0 is the failed group, state 1 + k that with k units lost.
    transitions = [(1 + spares, 0, working)]
    for lost in range(spares):
        dormant = (spares - lost) * dormancy * rate
        transitions.append((1 + lost, 2 + lost, working * (1.0 - switch) + dormant))
        transitions.append((1 + lost, 0, working * switch))
    chain = FailureChain(spares + 2, ((1, 1.0),), tuple(transitions))
    return chain.failed_by(1.0).p
