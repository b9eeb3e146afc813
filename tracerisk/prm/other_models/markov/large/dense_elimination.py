"""Elimination of the dense rest of a chain, in blocks of states.

The same steps as in `sparse_elimination`; what a block adds to the states after it is one
product of matrices without a negative entry.
"""

from __future__ import annotations

from tracerisk.prm.compiled.library import loop
from tracerisk.prm.other_models.markov.large.pattern import Array

_BLOCK = 96
_ROWS = 1024

_eliminate_block = loop("eliminate_block", "nnnddr", int)
"""Eliminates the states of a block among its own rows, and gathers the ways into it."""


def eliminate_dense(dense: Array, leaving: Array, smallest: float) -> int:
    """Eliminate all states of a matrix in place; its last column is the slack.

    dense: (m, m + 1), weights; on return the weights into earlier states stand below the
    diagonal and the shares of what leaves above; leaving: (m,), filled.
    Returns the place of a state that is left with less than `smallest`, or -1.
    """
    size = len(dense)
    for first in range(0, size, _BLOCK):
        last = min(first + _BLOCK, size)
        stuck: int = _eliminate_block(size, first, last, dense, leaving, smallest)
        if stuck >= 0:
            return stuck
        ahead = dense[first:last, last:]
        for top in range(last, size, _ROWS):
            rows = dense[top : top + _ROWS]
            rows[:, last:] += rows[:, first:last] @ ahead
    return -1
