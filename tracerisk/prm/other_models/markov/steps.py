"""The distribution of a small chain after a number of steps, without a subtraction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tracerisk.prm.numbers.arrays import np

_RENORMALISED_EVERY = 64

Rows = Sequence[Mapping[int, float]]


def distribution_after(
    transitions: Mapping[str, Mapping[str, float]],
    absorbing: Sequence[str],
    entry: str,
    steps: int,
) -> dict[str, float]:
    """Return the probability of each state after `steps` steps from `entry`.

    Rows are read as divided by their sums; absorbing states keep what reaches them.
    """
    names = (*transitions, *absorbing)
    index = {name: number for number, name in enumerate(names)}
    rows: list[dict[int, float]] = []
    for row in transitions.values():
        total = math.fsum(row.values())
        rows.append({index[t]: p / total for t, p in row.items() if p > 0.0})
    rows.extend({index[name]: 1.0} for name in absorbing)
    start = [0.0] * len(names)
    start[index[entry]] = 1.0
    values = after_steps(rows, start, steps)
    return dict(zip(names, values, strict=True))


def after_steps(rows: Rows, start: list[float], steps: int) -> list[float]:
    """Return a distribution after `steps` steps of a stochastic matrix.

    Each product is divided by its sum, which is one but for rounding: so what rounding does to
    all entries alike does not add up over the steps.
    """
    ways = sum(map(len, rows))
    squaring = (len(rows) ** 3 + len(rows) ** 2) * max(1, steps).bit_length()
    if steps * ways <= squaring:
        return _step(start, rows, steps)
    if len(rows) <= 24:
        return _square_in_python(start, rows, steps)
    return _in_arrays(start, rows, steps, squaring)


def _step(start: list[float], rows: Rows, steps: int) -> list[float]:
    now = start
    for number in range(1, steps + 1):
        now = multiplied(now, rows)
        if number % _RENORMALISED_EVERY == 0:
            now = normalised(now)
    return normalised(now)


def _square_in_python(start: list[float], rows: Rows, steps: int) -> list[float]:
    size = range(len(rows))
    matrix = [[row.get(j, 0.0) for j in size] for row in rows]
    now = start
    while steps:
        if steps & 1:
            now = _times(now, matrix)
        steps >>= 1
        if steps:
            matrix = [_times(row, matrix) for row in matrix]
    return now


def _times(row: Sequence[float], matrix: Sequence[Sequence[float]]) -> list[float]:
    columns = zip(*matrix, strict=True)
    return normalised([math.fsum(map(float.__mul__, row, column)) for column in columns])


def multiplied(now: Sequence[float], rows: Rows) -> list[float]:
    """Return a distribution after one step."""
    following = [0.0] * len(now)
    for mass, row in zip(now, rows, strict=True):
        if mass:
            for target, p in row.items():
                following[target] += mass * p
    return following


def normalised(row: Sequence[float]) -> list[float]:
    """Return a distribution divided by its sum."""
    total = math.fsum(row)
    return [p / total for p in row]


def _in_arrays(start: list[float], rows: Rows, steps: int, squaring: int) -> list[float]:
    """Step or square with NumPy, whichever takes fewer operations."""
    from tracerisk.prm.other_models.markov.large.array_steps import entries_of, power

    in_arrays: list[float] = power(np.array(start), entries_of(rows), steps, squaring).tolist()
    return in_arrays
