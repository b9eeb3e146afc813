"""Compiled elimination of a sparse chain, row by row, and the two solves with its result.

Grassmann, Taksar, Heyman (1985), as in `elimination`: no number is ever subtracted. Rows are
taken in the order of elimination, each with all that the states before it add to it; the states
of the dense rest only gather here, and are eliminated by `dense_elimination`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.markov.large.compiling import compiled_by_numba

Array = np.ndarray[Any, Any]


@compiled_by_numba
def _follows(out_state: Array, out_ptr: Array, out_end: Array, k: int) -> bool:
    """Return whether the state before k leads to k, and else to the same states as k."""
    before = out_ptr[k - 1]
    count = out_end[k] - out_ptr[k]
    if out_end[k - 1] - before != count + 1 or out_state[before] != k:
        return False
    same = 0
    while same < count and out_state[before + 1 + same] == out_state[out_ptr[k] + same]:
        same += 1
    return bool(same == count)


@compiled_by_numba
def eliminate_rows(
    n: int,
    head: int,
    order: Array,
    rank: Array,
    parent: Array,
    indptr: Array,
    indices: Array,
    data: Array,
    slack: Array,
    in_ptr: Array,
    out_ptr: Array,
    out_state: Array,
    smallest: float,
) -> tuple[Array, Array, Array, Array, Array, Array, Array, int]:
    """Eliminate the first `head` states by rank.

    Rows of `indptr`, `indices`, `data` and `slack`, the weight that leaves all states at once,
    go by state.
    `out_state` is given as a bound and returned with what is there, its ends in `out_end`.
    Returns in_end, in_state, in_weight: the weights into earlier states, by rows;
    out_end, out_share: the shares of what leaves a state, by rows; the weight that leaves each
    state; the dense rest with the slack as its last column; and the state that is left with
    less than `smallest`, or -1.
    """
    rest = n - head
    in_end = in_ptr[:n].copy()
    in_state = np.empty(in_ptr[n], np.int32)
    in_weight = np.empty(in_ptr[n], np.float64)
    out_end = out_ptr[:head].copy()
    out_share = np.empty(out_ptr[head], np.float64)
    leaving = np.zeros(n, np.float64)
    slack_share = np.zeros(head, np.float64)
    dense = np.zeros((rest, rest + 1), np.float64)
    paired = np.zeros(head, np.bool_)
    row = np.zeros(n, np.float64)
    mark = np.full(n, -1, np.int32)
    stack = np.empty(n, np.int32)
    path = np.empty(n, np.int32)
    for k in range(n):
        i = order[k]
        mark[k] = k
        top = n
        # Who is eliminated before this row and led to by it, each before those it leads to.
        for t in range(indptr[i], indptr[i + 1]):
            j = rank[indices[t]]
            row[j] = data[t]
            steps = 0
            while j != -1 and j < k and j < head and mark[j] != k:
                mark[j] = k
                path[steps] = j
                steps += 1
                j = parent[j]
            while steps:
                steps -= 1
                top -= 1
                stack[top] = path[steps]
        out_sum = slack[i]
        lost = 0.0
        filled = in_ptr[k]
        t = top
        while t < n:
            j = stack[t]
            t += 1
            weight = row[j]
            row[j] = 0.0
            if weight == 0.0:
                continue
            in_state[filled] = j
            in_weight[filled] = weight
            filled += 1
            added = weight * slack_share[j]
            if paired[j] and t < n and stack[t] == j + 1:
                # Both lead to the same states, but for the one to the other: one pass for both.
                t += 1
                first = out_ptr[j]
                second = row[j + 1] + weight * out_share[first]
                row[j + 1] = 0.0
                in_state[filled] = j + 1
                in_weight[filled] = second
                filled += 1
                shift = out_ptr[j + 1] - first - 1
                for s in range(first + 1, out_end[j]):
                    row[out_state[s]] += weight * out_share[s] + second * out_share[s + shift]
                added += second * slack_share[j + 1]
            else:
                for s in range(out_ptr[j], out_end[j]):
                    row[out_state[s]] += weight * out_share[s]
            total = out_sum + added
            lost += (out_sum - total) + added if out_sum >= added else (added - total) + out_sum
            out_sum = total
        in_end[k] = filled
        out_slack = out_sum + lost
        if k >= head:
            # The way back to oneself stands on the diagonal, and is never read.
            for j in range(head, n):
                dense[k - head, j - head] = row[j]
                row[j] = 0.0
            dense[k - head, rest] = out_slack
            continue
        row[k] = 0.0
        put = out_ptr[k]
        for t in range(out_ptr[k], out_ptr[k + 1]):
            j = out_state[t]
            weight = row[j]
            if weight == 0.0:
                continue
            row[j] = 0.0
            out_state[put] = j
            out_share[put] = weight
            put += 1
            total = out_sum + weight
            lost += (out_sum - total) + weight if out_sum >= weight else (weight - total) + out_sum
            out_sum = total
        out_end[k] = put
        out_sum += lost
        if not out_sum >= smallest:
            return (in_end, in_state, in_weight, out_end, out_share, leaving, dense, i)
        leaving[k] = out_sum
        slack_share[k] = out_slack / out_sum
        for t in range(out_ptr[k], put):
            out_share[t] /= out_sum
        if k > 0:
            paired[k - 1] = _follows(out_state, out_ptr, out_end, k)
    return (in_end, in_state, in_weight, out_end, out_share, leaving, dense, -1)


@compiled_by_numba
def solve_left(
    start: Array,
    head: int,
    leaving: Array,
    in_ptr: Array,
    in_end: Array,
    in_state: Array,
    in_weight: Array,
    out_ptr: Array,
    out_end: Array,
    out_state: Array,
    out_share: Array,
    dense: Array,
) -> Array:
    """Return u with u G = start, all by rank; G as in `factors`."""
    n = len(leaving)
    moved: Array = start.copy()
    for k in range(head):
        mass = moved[k]
        if mass != 0.0:
            for t in range(out_ptr[k], out_end[k]):
                moved[out_state[t]] += mass * out_share[t]
    for k in range(head, n):
        mass = moved[k]
        if mass != 0.0:
            for j in range(k + 1, n):
                moved[j] += mass * dense[k - head, j - head]
    for k in range(n - 1, -1, -1):
        value = moved[k] / leaving[k]
        moved[k] = value
        if value == 0.0:
            continue
        if k >= head:
            for j in range(head, k):
                moved[j] += value * dense[k - head, j - head]
        for t in range(in_ptr[k], in_end[k]):
            moved[in_state[t]] += value * in_weight[t]
    return moved


@compiled_by_numba
def solve_right(
    reward: Array,
    head: int,
    leaving: Array,
    in_ptr: Array,
    in_end: Array,
    in_state: Array,
    in_weight: Array,
    out_ptr: Array,
    out_end: Array,
    out_state: Array,
    out_share: Array,
    dense: Array,
) -> Array:
    """Return x with G x = reward, all by rank; G as in `factors`."""
    n = len(leaving)
    value: Array = reward.copy()
    for k in range(n):
        total = value[k]
        lost = 0.0
        for t in range(in_ptr[k], in_end[k]):
            added = in_weight[t] * value[in_state[t]]
            grown = total + added
            lost += (total - grown) + added if total >= added else (added - grown) + total
            total = grown
        if k >= head:
            for j in range(head, k):
                total += dense[k - head, j - head] * value[j]
        value[k] = (total + lost) / leaving[k]
    for k in range(n - 1, -1, -1):
        total = value[k]
        if k >= head:
            for j in range(k + 1, n):
                total += dense[k - head, j - head] * value[j]
        else:
            lost = 0.0
            for t in range(out_ptr[k], out_end[k]):
                added = out_share[t] * value[out_state[t]]
                grown = total + added
                lost += (total - grown) + added if total >= added else (added - grown) + total
                total = grown
            total += lost
        value[k] = total
    return value
