"""Elimination of the dense rest of a chain, in blocks of states.

The same steps as in `sparse_elimination`; what a block adds to the states after it is one
product of matrices without a negative entry.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.markov.large.compiling import compiled_by_numba

Array = np.ndarray[Any, Any]

_BLOCK = 96
_ROWS = 1024


def eliminate_dense(dense: Array, leaving: Array, smallest: float) -> int:
    """Eliminate all states of a matrix in place; its last column is the slack.

    dense: (m, m + 1), weights; on return the weights into earlier states stand below the
    diagonal and the shares of what leaves above; leaving: (m,), filled.
    Returns the place of a state that is left with less than `smallest`, or -1.
    """
    size = len(dense)
    for first in range(0, size, _BLOCK):
        last = min(first + _BLOCK, size)
        stuck = int(_eliminate_block(dense, first, last, leaving, smallest))
        if stuck >= 0:
            return stuck
        ahead = dense[first:last, last:]
        for top in range(last, size, _ROWS):
            rows = dense[top : top + _ROWS]
            rows[:, last:] += rows[:, first:last] @ ahead
    return -1


@compiled_by_numba
def _eliminate_block(dense: Array, first: int, last: int, leaving: Array, smallest: float) -> int:
    """Eliminate the states of a block among its own rows, and gather the ways into it."""
    size = dense.shape[0]
    for k in range(first, last):
        total = 0.0
        lost = 0.0
        for j in range(k + 1, size + 1):
            added = dense[k, j]
            grown = total + added
            lost += (total - grown) + added if total >= added else (added - grown) + total
            total = grown
        total += lost
        if not total >= smallest:
            return k
        leaving[k] = total
        for j in range(k + 1, size + 1):
            dense[k, j] /= total
        for i in range(k + 1, last):
            weight = dense[i, k]
            if weight != 0.0:
                for j in range(k + 1, size + 1):
                    dense[i, j] += weight * dense[k, j]
    for i in range(last, size):
        for k in range(first, last):
            weight = dense[i, k]
            if weight != 0.0:
                for j in range(k + 1, last):
                    dense[i, j] += weight * dense[k, j]
    return -1
