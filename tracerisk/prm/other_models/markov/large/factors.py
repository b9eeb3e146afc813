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
    """The weights between n transient states in compressed rows, without the diagonal."""

    indptr: Array
    """Start of each row in `indices` and `data`, and the end, (n + 1,) int64."""
    indices: Array
    """Target state of each way, (nnz,) int32."""
    data: Array
    """Weight of each way, above zero, (nnz,)."""
    slack: Array
    """Weight that leaves all transient states, by state, (n,)."""
    slack_low: Array
    """What the rounding of each entry of `slack` lost, (n,)."""
    ends: Array
    """Number of ways that each entry of `slack` sums, (n,)."""

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
    """How far elimination may fill a chain in before iteration takes its place."""

    dense_rest: int = 12_000
    """Most states that may be left when each is joined to half of the others."""
    entries: int = 250_000_000
    """Most numbers stored before the dense rest."""
    products: float = 3e10
    """Most products computed before the dense rest."""
    iterate_first: float = 1e10
    """Number of products above which iteration is tried first, and elimination only when its
    error cannot be bounded."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """An order of elimination of n states, and where it puts new ways."""

    order: Array
    """States in the order of elimination, (n,) int32."""
    rank: Array
    """Place of each state in `order`, (n,) int32."""
    head: int
    """Number of states eliminated as sparse rows; the rest is dense."""
    parent: Array
    """Rank of the first later state that each elimination leads to, -1 for none, by rank, (n,)."""
    in_ptr: Array
    """Start of the room for each state's weights into earlier states, by rank, (n + 1,) int64."""
    out_ptr: Array
    """Start of the room for each state's shares into later states, by rank, (head + 1,) int64."""
    joined_ptr: Array
    """Start of each state's neighbours in `joined`, and the end, (n + 1,)."""
    joined: Array
    """Neighbours of the states, whatever the direction of the way."""
    products: float
    """Approximate number of products that elimination takes."""


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """The eliminated chain: u G = start and G x = reward are solved without a subtraction."""

    plan: Plan
    """The order of elimination."""
    leaving: Array
    """Weight that leaves each state, by rank, (n,)."""
    rows: tuple[Array, ...]
    """Sparse rows as `eliminate_rows` returns them: pointers, ends, states and weights into
    earlier states, then into later ones."""
    dense: Array
    """The dense rest after elimination, (n - head, n - head + 1), slack in the last column."""

    def left(self, start: Array) -> Array:
        """Return u >= 0 with u G = start >= 0; both: (n,)."""
        return np.asarray(self._solve(solve_left, start))

    def right(self, reward: Array) -> Array:
        """Return x >= 0 with G x = reward >= 0; both: (n,)."""
        return np.asarray(self._solve(solve_right, reward))

    def _solve(self, solver: Any, given: Array) -> Array:
        ordered = np.ascontiguousarray(given, dtype=np.float64)[self.plan.order]
        array: Array = solver(ordered, self.plan.head, self.leaving, *self.rows, self.dense)
        return array[self.plan.rank]


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
