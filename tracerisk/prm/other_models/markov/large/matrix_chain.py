"""Markov chains as arrays: a million states need no million names."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.markov.large.array_steps import power
from tracerisk.prm.other_models.markov.large.factors import Budget, Weights
from tracerisk.prm.other_models.markov.large.matrix_solution import MatrixSolution
from tracerisk.prm.other_models.markov.large.pattern import (
    Array,
    Rows,
    not_reached_backwards,
    split,
    transposed,
)
from tracerisk.prm.other_models.markov.solver import CertifiedSolver

_ROW_TOLERANCE = 1e-9
_NAMED_IN_ERRORS = 5


@dataclass(frozen=True, slots=True, eq=False)
class MatrixChain:
    """An absorbing chain whose n states are the rows of a matrix.

    Made by `MarkovChain.from_matrix`, which checks it.
    """

    indptr: Array
    """Start of each row in `indices` and `data`, and the end, (n + 1,) int64."""
    indices: Array
    """Target state of each entry, (nnz,) int32."""
    data: Array
    """Probability of each entry, (nnz,)."""
    absorbing: Array
    """Whether each state is absorbing, (n,) booleans."""
    transient: Array
    """Indices of the other states, in ascending order, (n_transient,)."""
    totals: Array
    """Sum of the row of each transient state, (n_transient,)."""
    weights: Weights
    """The weights between the transient states."""
    names: tuple[str, ...] | None = None
    """Name of each state, (n,); `None` where states have only indices."""

    @classmethod
    def from_matrix(
        cls, matrix: Any, absorbing: Any = None, names: Sequence[str] | None = None
    ) -> MatrixChain:
        """Return the chain of a square matrix; see `MarkovChain.from_matrix`."""
        rows = _compressed(matrix)
        labels = _checked_names(names, len(rows[0]) - 1)
        _check_entries(rows, labels)
        chain = cls._split(rows, _absorbing_states(rows, absorbing, labels), labels)
        wrong = np.flatnonzero(~(np.abs(chain.totals - 1.0) <= _ROW_TOLERANCE))
        if len(wrong):
            state = int(chain.transient[wrong[0]])
            raise ModelError(
                f"state {labelled(state, labels)}: its transitions sum to "
                f"{float(chain.totals[wrong[0]])!r}; they must sum to 1"
            )
        return chain

    @classmethod
    def _split(cls, rows: Rows, absorbing: Array, names: tuple[str, ...] | None) -> MatrixChain:
        """Separate the transient states; raise ModelError when one is never absorbed."""
        transient = np.flatnonzero(~absorbing)
        place = (np.cumsum(~absorbing) - 1).astype(np.int32)
        *parts, totals = split(rows, absorbing, place, transient)
        weights = Weights(*parts)
        turned_ptr, turned, _ = transposed(weights.size, weights.rows)
        caught = not_reached_backwards(weights.size, turned_ptr, turned, weights.slack > 0.0)
        if len(caught):
            shown = [labelled(int(transient[k]), names) for k in caught[:_NAMED_IN_ERRORS]]
            more = len(caught) - len(shown)
            raise ModelError(
                f"no absorbing state can be reached from {', '.join(shown)}"
                f"{f' and {more} more states' if more else ''}; lead each to one"
                f"{'' if absorbing.any() else ' (there is none)'}"
            )
        return cls(*rows, absorbing, transient, totals, weights, names)

    @property
    def rows(self) -> Rows:
        """The matrix in compressed rows."""
        return self.indptr, self.indices, self.data

    @property
    def size(self) -> int:
        """How many states there are, absorbing ones included."""
        return len(self.absorbing)

    def solve(self, entry: int | str, budget: Budget | None = None) -> MatrixSolution:
        """Solve the chain that starts in the transient state `entry`.

        By elimination without a subtraction, as `MarkovChain.solve`; where that would fill in
        beyond `budget`, by iteration. Each result is refined in twice the working precision and
        comes with a bound of its relative error (docs/theory.md#large-chains).
        Raises ModelError when `entry` is not a transient state or a state is left less often than
        the smallest number of double precision; TooLargeError when an iteration's error cannot
        be bounded by 1e-9.
        """
        start = self._start(entry)
        solver = CertifiedSolver(
            self.weights,
            lambda state: labelled(int(self.transient[state]), self.names),
            "probability",
            budget,
        )
        first = np.zeros(len(self.transient))
        first[start] = 1.0
        return MatrixSolution(self, self.state(entry), solver, solver.left(first))

    def transient_distribution(self, entry: int | str, steps: int) -> Array:
        """Return the probability of each state after `steps` steps from `entry`: (n,).

        Raises ModelError when `entry` is not a transient state or `steps` is below zero.
        """
        if steps < 0:
            raise ModelError(f"{steps} steps; allowed: 0 or more")
        now = np.zeros(self.size)
        now[self.transient[self._start(entry)]] = 1.0
        counts = np.diff(self.indptr)
        sources = np.repeat(np.arange(self.size), counts)
        scale = np.ones(self.size)
        scale[self.transient] = self.totals
        inside = ~self.absorbing[sources]
        ends = np.flatnonzero(self.absorbing)
        rows = np.concatenate((sources[inside], ends))
        columns = np.concatenate((self.indices[inside].astype(np.int64), ends))
        values = np.concatenate((self.data[inside] / scale[sources[inside]], np.ones(len(ends))))
        squaring = float(self.size) ** 3 * max(1, steps).bit_length()
        return power(now, (rows, columns, values), steps, squaring)

    def state(self, given: int | str) -> int:
        """Return the index of a state given by index or name; raise ModelError for no such."""
        if isinstance(given, str):
            names = self.names or ()
            if given not in names:
                what = one_of(names, given) if names else "the states have no names, only indices"
                raise ModelError(f"'{given}' is not a state of the chain; {what}")
            return names.index(given)
        if not 0 <= given < self.size:
            raise ModelError(
                f"{given} is not a state of the chain; its states are 0 to {self.size - 1}"
            )
        return int(given)

    def chosen(self, targets: Iterable[int | str]) -> Array:
        """Return which states are among `targets`; raise ModelError unless all are absorbing."""
        chosen = np.zeros(self.size, np.bool_)
        for target in targets:
            state = self.state(target)
            if not self.absorbing[state]:
                raise ModelError(f"{labelled(state, self.names)} is not an absorbing state")
            chosen[state] = True
        return chosen

    def _start(self, entry: int | str) -> int:
        state = self.state(entry)
        if self.absorbing[state]:
            raise ModelError(
                f"the entry {labelled(state, self.names)} is not a transient state; "
                "start where the chain can leave"
            )
        return int(np.searchsorted(self.transient, state))


def _compressed(matrix: Any) -> Rows:
    """Return a square matrix in compressed rows; raise ModelError when it is none."""
    from scipy.sparse import csr_array, issparse

    if not issparse(matrix):
        matrix = np.asarray(matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise ModelError(
            f"a matrix of shape {tuple(matrix.shape)}; expected a row and a column for each state"
        )
    if not np.issubdtype(matrix.dtype, np.floating) and not np.issubdtype(matrix.dtype, np.integer):
        raise ModelError(f"a matrix of {matrix.dtype}; give floating-point numbers")
    rows = csr_array(matrix, dtype=np.float64)
    if not rows.has_canonical_format:
        rows = rows.copy()
        rows.sum_duplicates()
    return rows.indptr.astype(np.int64), rows.indices.astype(np.int32), rows.data


def _check_entries(rows: Rows, names: tuple[str, ...] | None) -> None:
    """Raise ModelError, naming row and column, when an entry is negative or not finite."""
    indptr, indices, data = rows
    if not len(data) or (data.min() >= 0.0 and data.max() < math.inf):
        return
    place = int(np.flatnonzero(~((data >= 0.0) & (data < math.inf)))[0])
    row = int(np.searchsorted(indptr, place, side="right")) - 1
    raise ModelError(
        f"state {labelled(row, names)}: {float(data[place])!r} to "
        f"{labelled(int(indices[place]), names)} is not a probability"
    )


def labelled(state: int, names: tuple[str, ...] | None) -> str:
    """Return how messages call a state."""
    return str(state) if names is None else f"'{names[state]}'"


def _checked_names(names: Sequence[str] | None, size: int) -> tuple[str, ...] | None:
    if names is None:
        return None
    labels = tuple(names)
    if len(labels) != size:
        raise ModelError(f"{len(labels)} names for {size} states; give one for each, or none")
    if len(set(labels)) < size:
        twice = next(label for label, count in Counter(labels).items() if count > 1)
        raise ModelError(f"duplicate state '{twice}' in the chain; rename one")
    return labels


def _absorbing_states(rows: Rows, given: Any, names: tuple[str, ...] | None) -> Array:
    indptr, indices, data = rows
    size = len(indptr) - 1
    sources = np.repeat(np.arange(size), np.diff(indptr))
    leads = (data > 0.0) & (indices != sources)
    leaves = np.zeros(size, np.bool_)
    leaves[sources[leads]] = True
    if given is None:
        return ~leaves
    chosen = np.asarray(given)
    if chosen.dtype == np.bool_:
        if chosen.shape != (size,):
            raise ModelError(
                f"absorbing: shape {chosen.shape}; expected one mark for each of {size} states"
            )
        ends: Array = chosen.copy()
    else:
        ends = np.zeros(size, np.bool_)
        for state in chosen.tolist():
            if names is not None and isinstance(state, str) and state in names:
                state = names.index(state)
            if not isinstance(state, int) or not 0 <= state < size:
                raise ModelError(
                    f"absorbing: {state!r} is not a state; the states are 0 to {size - 1}"
                )
            ends[state] = True
    left = np.flatnonzero(ends & leaves)
    if len(left):
        raise ModelError(
            f"state {labelled(int(left[0]), names)} is marked as absorbing but has transitions; "
            "empty its row"
        )
    return ends
