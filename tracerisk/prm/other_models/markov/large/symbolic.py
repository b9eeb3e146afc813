"""Where the elimination of a sparse chain puts new ways, before any number is computed.

J. W. H. Liu, "The role of elimination trees in sparse factorization", SIAM Journal on Matrix
Analysis and Applications 11 (1990).
`tracerisk/prm/compiled/chains.c` does it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tracerisk.prm.compiled.library import loop
from tracerisk.prm.other_models.markov.large.pattern import Array

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.factors import Plan


_elimination_tree = loop("elimination_tree", "iiliii")
_depth_first = loop("depth_first", "niiiiii")
_count_fill = loop("count_fill", "niiliiill")
_later_states = loop("later_states", "niiliiili")


def elimination_tree(n: int, order: Array, rank: Array, indptr: Array, indices: Array) -> Array:
    """Return each state's parent by rank: the first later one that its elimination leads to."""
    parent, ancestor = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
    _elimination_tree(order, rank, indptr, indices, parent, ancestor)
    return parent


def depth_first(n: int, head: int, order: Array, parent: Array) -> Array:
    """Return an equivalent order in which each subtree of the first `head` states is together."""
    child, sibling = np.full(n, -1, np.int32), np.full(n, -1, np.int32)
    result: Array = order.copy()
    _depth_first(head, order, parent, child, sibling, np.empty(n, np.int32), result)
    return result


def count_fill(
    n: int, head: int, order: Array, rank: Array, indptr: Array, indices: Array, parent: Array
) -> tuple[Array, Array]:
    """Return bounds of how many eliminated states are led to from each, and lead to later ones.

    The first `head` states are eliminated; both counts stand one place behind their state.
    """
    into, out = np.zeros(n + 1, np.int64), np.zeros(head + 1, np.int64)
    mark = np.full(n, -1, np.int32)
    _count_fill(head, order, rank, indptr, indices, parent, mark, into, out)
    return into, out


def later_states(how: Plan) -> Array:
    """Return for each of the first `how.head` states, by rank, which later ones it can lead to."""
    empty = np.empty(how.out_ptr[how.head], np.int32)
    ends = how.out_ptr[: how.head].copy()
    mark = np.full(len(how.order), -1, np.int32)
    joined = how.joined_ptr, how.joined
    _later_states(how.head, how.order, how.rank, *joined, how.parent, mark, ends, empty)
    return empty
