"""Where the elimination of a sparse chain puts new ways, before any number is computed.

J. W. H. Liu, "The role of elimination trees in sparse factorization", SIAM Journal on Matrix
Analysis and Applications 11 (1990).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.markov.large.compiling import compiled_by_numba

Array = np.ndarray[Any, Any]


@compiled_by_numba
def elimination_tree(n: int, order: Array, rank: Array, indptr: Array, indices: Array) -> Array:
    """Return each state's parent by rank: the first later one that its elimination leads to."""
    parent = np.full(n, -1, np.int32)
    ancestor = np.full(n, -1, np.int32)
    for k in range(n):
        i = order[k]
        for t in range(indptr[i], indptr[i + 1]):
            j = rank[indices[t]]
            while j != -1 and j < k:
                following = ancestor[j]
                ancestor[j] = k
                if following == -1:
                    parent[j] = k
                j = following
    return parent


@compiled_by_numba
def depth_first(n: int, head: int, order: Array, parent: Array) -> Array:
    """Return an equivalent order in which each subtree of the first `head` states is together."""
    child = np.full(n, -1, np.int32)
    sibling = np.full(n, -1, np.int32)
    for k in range(head - 1, -1, -1):
        above = parent[k]
        if above != -1 and above < head:
            sibling[k] = child[above]
            child[above] = k
    result: Array = order.copy()
    stack = np.empty(n, np.int32)
    placed = 0
    for root in range(head):
        if parent[root] != -1 and parent[root] < head:
            continue
        depth = 1
        stack[0] = root
        while depth:
            k = stack[depth - 1]
            below = child[k]
            if below != -1:
                child[k] = sibling[below]
                stack[depth] = below
                depth += 1
            else:
                depth -= 1
                result[placed] = order[k]
                placed += 1
    return result


@compiled_by_numba
def count_fill(
    n: int, head: int, order: Array, rank: Array, indptr: Array, indices: Array, parent: Array
) -> tuple[Array, Array]:
    """Return bounds of how many eliminated states are led to from each, and lead to later ones.

    The first `head` states are eliminated; both counts stand one place behind their state.
    """
    into = np.zeros(n + 1, np.int64)
    out = np.zeros(head + 1, np.int64)
    mark = np.full(n, -1, np.int32)
    for k in range(n):
        mark[k] = k
        i = order[k]
        for t in range(indptr[i], indptr[i + 1]):
            j = rank[indices[t]]
            while j != -1 and j < k and j < head and mark[j] != k:
                mark[j] = k
                into[k + 1] += 1
                out[j + 1] += 1
                j = parent[j]
    return into, out


@compiled_by_numba
def later_states(
    n: int,
    head: int,
    order: Array,
    rank: Array,
    indptr: Array,
    indices: Array,
    parent: Array,
    starts: Array,
) -> Array:
    """Return for each of the first `head` states, by rank, which later ones it can lead to."""
    found = np.empty(starts[head], np.int32)
    free = starts[:head].copy()
    mark = np.full(n, -1, np.int32)
    for k in range(n):
        mark[k] = k
        i = order[k]
        for t in range(indptr[i], indptr[i + 1]):
            j = rank[indices[t]]
            while j != -1 and j < k and j < head and mark[j] != k:
                mark[j] = k
                found[free[j]] = k
                free[j] += 1
                j = parent[j]
    return found
