"""How long, or how often, a chain is in each state up to a moment, without a subtraction."""

from __future__ import annotations

from itertools import accumulate
from typing import Any

from tracerisk.errors import TooLargeError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.other_models.markov.steps import Rows, multiplied
from tracerisk.prm.other_models.markov.uniformisation import (
    dense,
    halvings_of,
    moves_in,
    poisson_weights,
    series,
    stepped,
    uniform,
)

_IN_PYTHON = 2_000_000
_WORK = 1e9
_DENSE = 2_000


def visits_within(rows: Rows, start: list[float], steps: int) -> list[float]:
    """Return the mean number of visits to each state in the first `steps` steps.

    The start counts as a visit, what is reached by the last step does not; `rows` are those of
    a stochastic matrix. Raises TooLargeError when the chain is large and the steps are many.
    """
    if steps == 0:
        return [0.0] * len(rows)
    work = float(steps) * sum(map(len, rows))
    squaring = 3.0 * float(len(rows)) ** 3 * steps.bit_length()
    if work <= _IN_PYTHON:
        total = now = start
        for _ in range(steps - 1):
            now = multiplied(now, rows)
            total = [t + p for t, p in zip(total, now, strict=True)]
        return total
    if len(rows) <= _DENSE and squaring < 50.0 * work:
        visits: list[float] = _doubled(start, dense(rows), np.eye(len(rows)), 1.0, steps).tolist()
        return visits
    if work > _WORK:
        raise TooLargeError(f"{len(rows)} states over {steps} steps; ask for fewer steps")
    shares = series(start, rows, 0, [1.0 / steps] * steps)
    return [share * steps for share in shares]


def time_within(rates: Rows, start: list[float], time: float) -> list[float]:
    """Return the mean time in each state up to `time`; `rates[i][j]` leads from i to j.

    By uniformisation: before the k-th move at the common rate q, a state is kept for as long as
    the probability of more than k moves, over q, says. Raises TooLargeError as `after_time`.
    """
    fastest, rows = uniform(rates)
    mean = moves_in(time, fastest)
    if mean == 0.0:
        return [p * time for p in start]
    if stepped(rows, mean):
        return [p * time for p in series(start, rows, 0, _tails(mean))]
    halvings = halvings_of(mean)
    short = time / 2.0**halvings
    first, weights = poisson_weights(mean / 2.0**halvings)
    assert first == 0
    one = dense(rows)
    now = np.eye(len(rows))
    moved, kept = np.zeros_like(one), np.zeros_like(one)
    tails = _tails(mean / 2.0**halvings)
    for number, weight in enumerate(weights):
        moved += weight * now
        if number < len(tails):
            kept += tails[number] * now
        now = now @ one
    kept *= short / kept.sum(axis=1, keepdims=True)
    tolist: list[float] = _doubled(start, moved, kept, short, 2**halvings).tolist()
    return tolist


def _tails(mean: float) -> list[float]:
    """Return the probability of more than k moves for k = 0, 1, ..., as long as it counts."""
    first, weights = poisson_weights(mean)
    above = list(accumulate(reversed(weights)))[::-1]
    return [1.0] * first + above[1:]


def _doubled(start: list[float], moved: Any, kept: Any, unit: float, count: int) -> Any:
    """Return what `count` periods add up to, from the moves and the stays of one.

    moved, kept: (n, n), their rows sum to 1 and to `unit`; each product is divided by its sums.
    """
    now = np.array(start)
    total = np.zeros(len(start))
    while True:
        if count & 1:
            total += now @ kept
            now = now @ moved
            now = now / now.sum()
        count >>= 1
        if not count:
            return total
        unit *= 2.0
        kept = kept + moved @ kept
        kept *= unit / kept.sum(axis=1, keepdims=True)
        moved = moved @ moved
        moved = moved / moved.sum(axis=1, keepdims=True)
