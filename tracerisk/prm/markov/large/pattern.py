"""Compiled passes over the pattern of a sparse matrix: its transpose, its symmetric closure."""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.markov.large.compiling import compiled_by_numba
from tracerisk.prm.markov.large.residual import exact_sum

Array = np.ndarray[Any, Any]


@compiled_by_numba
def transposed(n: int, indptr: Array, indices: Array, data: Array) -> tuple[Array, Array, Array]:
    """Return the transpose of an n x n matrix in compressed rows, its rows sorted."""
    starts = np.zeros(n + 1, np.int64)
    for j in indices:
        starts[j + 1] += 1
    for i in range(n):
        starts[i + 1] += starts[i]
    free = starts[:-1].copy()
    rows = np.empty(len(indices), np.int32)
    values = np.empty(len(indices), np.float64)
    for i in range(n):
        for t in range(indptr[i], indptr[i + 1]):
            place = free[indices[t]]
            free[indices[t]] = place + 1
            rows[place] = i
            values[place] = data[t]
    return starts, rows, values


@compiled_by_numba
def neighbours(
    n: int, indptr: Array, indices: Array, turned_ptr: Array, turned: Array
) -> tuple[Array, Array]:
    """Return who is joined to whom in either direction, themselves left out.

    `turned_ptr` and `turned` are the pattern of the transpose.
    """
    seen = np.full(n, -1, np.int32)
    starts = np.zeros(n + 1, np.int64)
    found = np.empty(len(indices) + len(turned), np.int32)
    count = 0
    for i in range(n):
        seen[i] = i
        for t in range(indptr[i], indptr[i + 1]):
            j = indices[t]
            if seen[j] != i:
                seen[j] = i
                found[count] = j
                count += 1
        for t in range(turned_ptr[i], turned_ptr[i + 1]):
            j = turned[t]
            if seen[j] != i:
                seen[j] = i
                found[count] = j
                count += 1
        starts[i + 1] = count
    return starts, found[:count].copy()


@compiled_by_numba
def not_reached_backwards(n: int, turned_ptr: Array, turned: Array, ends: Array) -> Array:
    """Return the states from which no path leads to one where `ends` holds, in order."""
    reached = ends.copy()
    waiting = np.empty(n, np.int32)
    count = 0
    for i in range(n):
        if reached[i]:
            waiting[count] = i
            count += 1
    while count:
        count -= 1
        i = waiting[count]
        for t in range(turned_ptr[i], turned_ptr[i + 1]):
            j = turned[t]
            if not reached[j]:
                reached[j] = True
                waiting[count] = j
                count += 1
    return np.flatnonzero(~reached)


@compiled_by_numba
def split(
    indptr: Array, indices: Array, data: Array, absorbing: Array, place: Array, transient: Array
) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Split the rows of the transient states into the ways between them and what leaves them.

    `place` numbers the transient states, `transient` holds them in that order.
    Returns indptr, indices and data of the ways between different transient states, and for
    each transient state the sum of its ways to absorbing ones, what its rounding lost, how many
    they are, and the sum of its whole row.
    """
    n = len(transient)
    starts = np.zeros(n + 1, np.int64)
    targets = np.empty(len(indices), np.int32)
    values = np.empty(len(indices), np.float64)
    slack = np.zeros(n, np.float64)
    slack_low = np.zeros(n, np.float64)
    ends = np.zeros(n, np.int32)
    totals = np.zeros(n, np.float64)
    count = 0
    for k in range(n):
        i = transient[k]
        leaving = lost_leaving = 0.0
        total = lost = 0.0
        for t in range(indptr[i], indptr[i + 1]):
            weight = data[t]
            if weight == 0.0:
                continue
            grown = total + weight
            lost += (total - grown) + weight if total >= weight else (weight - grown) + total
            total = grown
            j = indices[t]
            if absorbing[j]:
                leaving, carried = exact_sum(leaving, weight)
                leaving, lost_leaving = exact_sum(leaving, lost_leaving + carried)
                ends[k] += 1
            elif j != i:
                targets[count] = place[j]
                values[count] = weight
                count += 1
        starts[k + 1] = count
        slack[k] = leaving
        slack_low[k] = lost_leaving
        totals[k] = total + lost
    return starts, targets[:count].copy(), values[:count].copy(), slack, slack_low, ends, totals


@compiled_by_numba
def gathered(
    indptr: Array, indices: Array, data: Array, chosen: Array, transient: Array, stay: Array
) -> Array:
    """Return for each state where `chosen` holds the sum of the ways into it times `stay`."""
    n = len(chosen)
    total = np.zeros(n, np.float64)
    lost = np.zeros(n, np.float64)
    for k in range(len(transient)):
        i = transient[k]
        for t in range(indptr[i], indptr[i + 1]):
            j = indices[t]
            if chosen[j]:
                added = stay[k] * data[t]
                grown = total[j] + added
                if total[j] >= added:
                    lost[j] += (total[j] - grown) + added
                else:
                    lost[j] += (added - grown) + total[j]
                total[j] = grown
    return total + lost


@compiled_by_numba
def row_sums_into(
    indptr: Array, indices: Array, data: Array, chosen: Array, transient: Array
) -> tuple[Array, Array]:
    """Return for each transient state the sum of its ways to states where `chosen` holds.

    And what its rounding lost.
    """
    sums = np.zeros(len(transient), np.float64)
    low = np.zeros(len(transient), np.float64)
    for k in range(len(transient)):
        i = transient[k]
        total = lost = 0.0
        for t in range(indptr[i], indptr[i + 1]):
            if chosen[indices[t]]:
                total, carried = exact_sum(total, data[t])
                total, lost = exact_sum(total, lost + carried)
        sums[k] = total
        low[k] = lost
    return sums, low
