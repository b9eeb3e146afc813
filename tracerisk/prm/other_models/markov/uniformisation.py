"""The distribution of a chain in continuous time at one moment, by uniformisation.

Jensen (1953): moves are drawn at one common rate, some of them from a state to itself, so that
their number is Poisson. B. L. Fox, P. W. Glynn, "Computing Poisson probabilities",
Communications of the ACM 31 (1988): the weights grow from the mode outwards, and are divided
by their sum.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from tracerisk.errors import TooLargeError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.other_models.markov.steps import Rows, multiplied, normalised

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
    rows = [{index[t]: r for t, r in row.items()} for row in rates.values()]
    rows.extend({} for _ in absorbing)
    start = [0.0] * len(names)
    start[index[entry]] = 1.0
    return dict(zip(names, after_time(rows, start, time), strict=True))


def after_time(rates: Rows, start: list[float], time: float) -> list[float]:
    """Return a distribution after a time; `rates[i][j]` is the rate of going from i to j.

    Raises TooLargeError when the chain is large and moves too often.
    """
    fastest, rows = uniform(rates)
    mean = moves_in(time, fastest)
    if mean == 0.0:
        return start
    if stepped(rows, mean):
        first, weights = poisson_weights(mean)
        return series(start, rows, first, weights)
    return _squared(start, rows, mean)


def moves_in(time: float, fastest: float) -> float:
    """Return how many moves are to be expected; raise TooLargeError beyond all numbers."""
    mean = fastest * time
    if not mean < math.inf:
        raise TooLargeError(
            f"a chain that moves {fastest:.3g} times in a unit of time, over {time:.3g} of them, "
            "makes too many transitions to count; give a shorter time"
        )
    return mean


def uniform(rates: Rows) -> tuple[float, Rows]:
    """Return the common rate of all moves, and the probabilities of the moves at that rate."""
    leaving = [math.fsum(r for t, r in row.items() if t != s) for s, row in enumerate(rates)]
    fastest = max(leaving, default=0.0) * _HEADROOM
    rows: list[dict[int, float]] = []
    for state, (row, total) in enumerate(zip(rates, leaving, strict=True)):
        if total == 0.0:
            rows.append({state: 1.0})
            continue
        moves = {t: r / fastest for t, r in row.items() if r > 0.0 and t != state}
        moves[state] = 1.0 - total / fastest
        rows.append(moves)
    return fastest, rows


def halvings_of(mean: float) -> int:
    """Return how often a time is halved until so many moves in it come to about one."""
    return max(0, math.ceil(math.log2(mean)))


def stepped(rows: Rows, mean: float) -> bool:
    """Return whether a mean number of moves is taken one by one, else by squaring.

    Raises TooLargeError when it is too many for either.
    """
    ways = sum(map(len, rows))
    stepping = (mean + 40.0 * math.sqrt(mean) + 200.0) * ways
    squaring = float(len(rows)) ** 3 * (halvings_of(mean) + 200)
    if stepping > squaring and len(rows) <= _DENSE:
        return False
    if stepping > _WORK:
        raise TooLargeError(
            f"{len(rows)} states that move {mean:.1e} times in the time asked for; "
            "ask for a shorter time or the steady state, or leave out the fastest moves"
        )
    return True


def series(start: list[float], rows: Rows, first: int, weights: Sequence[float]) -> list[float]:
    """Sum the distributions after `first` moves and on, each weighed; divided by the sum."""
    if sum(map(len, rows)) * len(weights) > 2_000_000:
        from tracerisk.prm.other_models.markov.large.array_steps import weighted_steps

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


def dense(rows: Rows) -> Any:
    """Return the matrix of rows."""
    matrix = np.zeros((len(rows), len(rows)))
    for state, row in enumerate(rows):
        for target, p in row.items():
            matrix[state, target] = p
    return matrix


def _squared(start: list[float], rows: Rows, mean: float) -> list[float]:
    """Square the matrix of a short time, each row divided by its sum each time."""
    # Squaring k times leaves a mean of about one for the series.
    halvings = halvings_of(mean)
    one = dense(rows)
    _, weights = poisson_weights(mean / 2.0**halvings)
    now = np.eye(len(rows))
    total = weights[0] * now
    for weight in weights[1:]:
        now = now @ one
        total += weight * now
    for _ in range(halvings):
        total = total / total.sum(axis=1, keepdims=True)
        total = total @ total
    last = np.array(start) @ total
    tolist: list[float] = (last / last.sum()).tolist()
    return tolist
