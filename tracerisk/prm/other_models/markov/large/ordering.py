"""The order in which states leave a sparse chain: the one with the fewest new ways first.

Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM Journal on Matrix
Analysis and Applications 17 (1996): a quotient graph, in which an eliminated state stands for
all the ways that it left behind, with bounds of the degrees in place of the degrees.
`tracerisk/prm/compiled/ordering.c` finds it.
"""

from __future__ import annotations

import numpy as np

from tracerisk.prm.compiled.library import loop
from tracerisk.prm.other_models.markov.large.pattern import Array

TOO_DENSE = -1
"""In place of the start of the dense rest: elimination would fill in beyond the budget."""

_minimum_degree = loop("minimum_degree", "linnrilii", int)


def minimum_degree(
    n: int, indptr: Array, indices: Array, largest_rest: int, products: float
) -> tuple[Array, int]:
    """Return an elimination order of a symmetric pattern, and where its dense rest begins.

    The rest, in which each state is joined to half of the others or more, is left in the order
    of its indices.
    The start is `TOO_DENSE` when the rest would have more than `largest_rest` states, or
    elimination would take more than about `products` products before it.
    """
    order = np.empty(n, np.int32)
    if n == 0:
        return order, 0
    capacity = len(indices) + len(indices) // 5 + n + 1
    head: int = _minimum_degree(
        indptr,
        indices,
        max(16, int(10.0 * np.sqrt(n))),
        largest_rest,
        products,
        np.empty(2 * capacity, np.int32),
        np.empty(7 * n, np.int64),
        np.empty(9 * n, np.int32),
        order,
    )
    return order, head
