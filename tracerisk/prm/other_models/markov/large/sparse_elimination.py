"""Elimination of a sparse chain, row by row, and the two solves with its result.

Grassmann, Taksar, Heyman (1985), as in `elimination`: no number is ever subtracted. Rows are
taken in the order of elimination, each with all that the states before it add to it; the states
of the dense rest only gather here, and are eliminated by `dense_elimination`.
`tracerisk/prm/compiled/chains.c` does it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tracerisk.prm.compiled.library import loop
from tracerisk.prm.other_models.markov.large.pattern import Array

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.factors import Plan, Weights


# head; order, rank, parent; the rows; in_; out_; leaving, dense; scratch; smallest
_eliminate_rows = loop("eliminate_rows", "niiiliddllidllidddd?diiir", int)
_SOLVES = "nddllidllidd"
_solve_left = loop("solve_left", _SOLVES)
_solve_right = loop("solve_right", _SOLVES)


def eliminate_rows(
    weights: Weights, how: Plan, out_state: Array, smallest: float
) -> tuple[Array, tuple[Array, ...], Array, int]:
    """Eliminate the first `how.head` states by rank.

    `out_state` is given as a bound and returned with what is there, its ends in `out_end`.
    Returns the weight that leaves each state; the rows in_ptr, in_end, in_state, in_weight: the
    weights into earlier states, and out_ptr, out_end, out_state, out_share: the shares of what
    leaves a state; the dense rest with the slack as its last column; and the state that is left
    with less than `smallest`, or -1.
    """
    n, head, in_ptr, out_ptr = weights.size, how.head, how.in_ptr, how.out_ptr
    rest = n - head
    rows = (
        *(in_ptr, in_ptr[:n].copy(), np.empty(in_ptr[n], np.int32), np.empty(in_ptr[n])),
        *(out_ptr, out_ptr[:head].copy(), out_state, np.empty(out_ptr[head])),
    )
    leaving = np.zeros(n)
    dense = np.zeros((rest, rest + 1))
    stuck: int = _eliminate_rows(
        head,
        *(how.order, how.rank, how.parent),
        *(*weights.rows, weights.slack),
        *rows,
        *(leaving, dense),
        *(np.zeros(head), np.zeros(head, np.bool_), np.zeros(n)),
        *(np.full(n, -1, np.int32), np.empty(n, np.int32), np.empty(n, np.int32)),
        smallest,
    )
    return leaving, rows, dense, stuck


def solve_left(start: Array, head: int, leaving: Array, *rows: Array) -> Array:
    """Return u with u G = start, all by rank; `rows` are those of `Factors`."""
    moved: Array = start.copy()
    _solve_left(head, moved, leaving, *rows)
    return moved


def solve_right(reward: Array, head: int, leaving: Array, *rows: Array) -> Array:
    """Return x with G x = reward, all by rank; `rows` are those of `Factors`."""
    value: Array = reward.copy()
    _solve_right(head, value, leaving, *rows)
    return value
