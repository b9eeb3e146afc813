"""A large sparse chain after elimination, and how much of it elimination can take.

The matrix is G = diag(s) - W: W holds the weights of the ways between different transient
states, and s what leaves each of them, `slack` included, the weight that leaves them all. With
probabilities for weights this is I - Q, with rates the negative generator; only W and the slack
are ever read, so nothing is subtracted to find s.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracerisk.prm.numbers.elimination import Label, StuckStateError
from tracerisk.prm.other_models.markov.large.dense_elimination import eliminate_dense
from tracerisk.prm.other_models.markov.large.ordering import TOO_DENSE, minimum_degree
from tracerisk.prm.other_models.markov.large.pattern import Array, Rows, neighbours, transposed
from tracerisk.prm.other_models.markov.large.sparse_elimination import (
    eliminate_rows,
    solve_left,
    solve_right,
)
from tracerisk.prm.other_models.markov.large.symbolic import (
    count_fill,
    depth_first,
    elimination_tree,
    later_states,
)


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """The weights between n transient states in compressed rows, without the diagonal.

    indptr: (n + 1,) int64; indices: (nnz,) int32; data: (nnz,), above zero; slack: (n,), the sum
    of `ends` ways each, and slack_low: (n,), what its rounding lost.
    """

    indptr: Array
    indices: Array
    data: Array
    slack: Array
    slack_low: Array
    ends: Array

    @property
    def size(self) -> int:
        """How many states there are."""
        return len(self.slack)

    @property
    def rows(self) -> Rows:
        """The ways in compressed rows."""
        return self.indptr, self.indices, self.data


@dataclass(frozen=True, slots=True)
class Budget:
    """How far elimination may fill a chain in before iteration takes its place.

    `dense_rest` states at most may be left when each is joined to half of the others;
    `entries` and `products` bound what is stored and computed before that.
    Above `iterate_first` products iteration is tried first, and elimination only when its error
    cannot be bounded.
    """

    dense_rest: int = 12_000
    entries: int = 250_000_000
    products: float = 3e10
    iterate_first: float = 1e10


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """An order of elimination, where it puts new ways, and about how many products it takes."""

    order: Array
    rank: Array
    head: int
    parent: Array
    in_ptr: Array
    out_ptr: Array
    joined_ptr: Array
    joined: Array
    products: float


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """The eliminated chain: u G = start and G x = reward are solved without a subtraction.

    leaving, rows, dense: as `eliminate_rows` returns them, the dense rest eliminated.
    """

    plan: Plan
    leaving: Array
    rows: tuple[Array, ...]
    dense: Array

    def left(self, start: Array) -> Array:
        """Return u >= 0 with u G = start >= 0; both: (n,)."""
        return np.asarray(self._solve(solve_left, start))

    def right(self, reward: Array) -> Array:
        """Return x >= 0 with G x = reward >= 0; both: (n,)."""
        return np.asarray(self._solve(solve_right, reward))

    def _solve(self, solver: Any, given: Array) -> Array:
        ordered = np.ascontiguousarray(given, dtype=np.float64)[self.plan.order]
        found: Array = solver(ordered, self.plan.head, self.leaving, *self.rows, self.dense)
        return found[self.plan.rank]


def plan(weights: Weights, budget: Budget) -> Plan | None:
    """Return how to eliminate a chain, or `None` where that would outgrow the budget."""
    n = weights.size
    turned_ptr, turned, _ = transposed(n, weights.rows)
    joined_ptr, joined = neighbours(n, weights.indptr, weights.indices, turned_ptr, turned)
    order, head = minimum_degree(n, joined_ptr, joined, budget.dense_rest, budget.products)
    if head == TOO_DENSE:
        return None
    rank = _ranks(order)
    parent = elimination_tree(n, order, rank, joined_ptr, joined)
    order = depth_first(n, head, order, parent)
    rank = _ranks(order)
    parent = elimination_tree(n, order, rank, joined_ptr, joined)
    into, out = count_fill(n, head, order, rank, joined_ptr, joined, parent)
    products = float(np.square(out.astype(np.float64)).sum())
    if into.sum() + out.sum() > budget.entries or products > budget.products:
        return None
    # A product of dense matrices takes about an eighth of the time of so many single ones.
    products += float(n - head) ** 3 / 8.0
    ends = np.cumsum(into), np.cumsum(out)
    return Plan(order, rank, head, parent, *ends, joined_ptr, joined, products)


def eliminate(
    weights: Weights, how: Plan, label: Label = str, kind: str = "probability"
) -> Factors:
    """Return the eliminated chain; `label` and `kind` are for messages, as of a `Pattern`.

    Raises StuckStateError when a state is left with less than the smallest normal double.
    """
    smallest = sys.float_info.min
    leaving, rows, dense, stuck = eliminate_rows(weights, how, later_states(how), smallest)
    if stuck < 0:
        place = eliminate_dense(dense, leaving[how.head :], smallest)
        stuck = int(how.order[how.head + place]) if place >= 0 else -1
    if stuck >= 0:
        raise StuckStateError(label(stuck), kind)
    return Factors(how, leaving, rows, dense)


def _ranks(order: Array) -> Array:
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    return rank
