"""The distribution of a chain in continuous time at one moment, by uniformisation.

Jensen (1953): moves are drawn at one common rate, some of them from a state to itself, so that
their number is Poisson. B. L. Fox, P. W. Glynn, "Computing Poisson probabilities",
Communications of the ACM 31 (1988): the weights grow from the mode outwards, and are divided
by their sum.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tracerisk.errors import TooLargeError
from tracerisk.prm.markov.steps import Rows, multiplied, normalised

_SMALLEST_WEIGHT = 1e-280
_HEADROOM = 1.125
"""The common rate over the fastest: keeps the way of each state to itself above 1/9."""
_DENSE = 2_000
_WORK = 2e10


def poisson_weights(mean: float) -> tuple[int, list[float]]:
    """Return the first count and the probabilities of it and those after it.

    Counts less than 1e-280 times as likely as the likeliest are left out: together they are
    less likely than 1e-250 for means up to 1e20.
    """
    mode = int(mean)
    below = [1.0]
    count = mode
    while count > 0 and below[-1] > _SMALLEST_WEIGHT:
        below.append(below[-1] * (count / mean))
        count -= 1
    above = []
    weight = 1.0
    following = mode
    while weight > _SMALLEST_WEIGHT:
        following += 1
        weight *= mean / following
        above.append(weight)
    weights = below[::-1] + above
    total = math.fsum(weights)
    return count, [weight / total for weight in weights]


def distribution_at(
    rates: Mapping[str, Mapping[str, float]],
    absorbing: Sequence[str],
    entry: str,
    time: float,
) -> dict[str, float]:
    """Return the probability of each state at `time`.

    Raises TooLargeError when the chain is large and moves too often.
    """
    names = (*rates, *absorbing)
    index = {name: number for number, name in enumerate(names)}
    leaving = [math.fsum(r for t, r in row.items() if t != s) for s, row in rates.items()]
    fastest = max(leaving, default=0.0) * _HEADROOM
    mean = fastest * time
    start = [0.0] * len(names)
    start[index[entry]] = 1.0
    if mean == 0.0:
        return dict(zip(names, start, strict=True))
    rows: list[dict[int, float]] = []
    for (state, row), total in zip(rates.items(), leaving, strict=True):
        moves = {index[t]: r / fastest for t, r in row.items() if r > 0.0 and t != state}
        moves[index[state]] = 1.0 - total / fastest
        rows.append(moves)
    rows.extend({index[name]: 1.0} for name in absorbing)
    ways = sum(map(len, rows))
    # Squaring k times leaves a mean of about one for the series.
    halvings = max(0, math.ceil(math.log2(mean)))
    stepping = (mean + 40.0 * math.sqrt(mean) + 200.0) * ways
    squaring = float(len(names)) ** 3 * (halvings + 200)
    if stepping <= squaring or len(names) > _DENSE:
        if stepping > _WORK:
            raise TooLargeError(
                f"{len(names)} states that move {mean:.1e} times in the time asked for; "
                "ask for a shorter time or the steady state, or leave out the fastest moves"
            )
        found = _series(start, rows, mean)
    else:
        found = _squared(index[entry], rows, mean, halvings)
    return dict(zip(names, found, strict=True))


def _series(start: list[float], rows: Rows, mean: float) -> list[float]:
    """Sum the distributions after each number of moves, weighed with its probability."""
    first, weights = poisson_weights(mean)
    if sum(map(len, rows)) * len(weights) > 2_000_000:
        from tracerisk.prm.markov.large.array_steps import weighted_steps

        summed: list[float] = weighted_steps(start, rows, first, weights).tolist()
        return summed
    now = start
    for _ in range(first):
        now = multiplied(now, rows)
    total = [weights[0] * p for p in now]
    for weight in weights[1:]:
        now = multiplied(now, rows)
        total = [t + weight * p for t, p in zip(total, now, strict=True)]
    return normalised(total)


def _squared(entry: int, rows: Rows, mean: float, halvings: int) -> list[float]:
    """Square the matrix of a short time, each row divided by its sum each time."""
    from tracerisk.prm.numbers.arrays import np

    size = len(rows)
    one = np.zeros((size, size))
    for state, row in enumerate(rows):
        for target, p in row.items():
            one[state, target] = p
    _, weights = poisson_weights(mean / 2.0**halvings)
    now = np.eye(size)
    total = weights[0] * now
    for weight in weights[1:]:
        now = now @ one
        total += weight * now
    for _ in range(halvings):
        total = total / total.sum(axis=1, keepdims=True)
        total = total @ total
    found: list[float] = (total[entry] / total[entry].sum()).tolist()
    return found
