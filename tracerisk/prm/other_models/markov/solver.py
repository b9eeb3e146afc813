"""Which way a chain is solved: elimination in Python, compiled elimination, or iteration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

from tracerisk.errors import TooLargeError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.elimination import Elimination, FilledInError, Label, Pattern

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.certificate import Certified
    from tracerisk.prm.other_models.markov.large.factors import Budget, Factors, Plan, Weights
    from tracerisk.prm.other_models.markov.large.pattern import Array

SMALL = 20_000
"""Chains of up to so many states are solved with no array library imported, if they stay sparse."""
SMALL_WAYS = 200_000
_SMALL_PRODUCTS = 2_000_000
"""How many products plain elimination may take; so many take about a second."""
_TRUSTED = 1e-13
_BOUND = 1e-9
"""An iteration is an answer only with a certified relative error below this."""


class WeightSolver(Protocol):
    """Solves u G = start and G x = reward, G as in `factors`, for numbers that are not negative."""

    def left(self, start: Sequence[float]) -> Sequence[float]:
        """Return u with u G = start."""

    def right(self, reward: Sequence[float]) -> Sequence[float]:
        """Return x with G x = reward."""


class CertifiedSolver:
    """Solves a large chain, refines each solution and bounds its relative error.

    By elimination, or by iteration where elimination would fill in.
    Raises ModelError when a state is left with less than the smallest normal double;
    TooLargeError from a solve by iteration whose error cannot be bounded by 1e-9.
    """

    def __init__(
        self, weights: Weights, label: Label, kind: str, budget: Budget | None = None
    ) -> None:
        from tracerisk.prm.other_models.markov.large import factors
        from tracerisk.prm.other_models.markov.large.certificate import Certifier

        self._weights = weights
        self._certifier = Certifier(weights)
        self._label = label
        self._kind = kind
        self._eliminated: Factors | None = None
        limits = budget or factors.Budget()
        self._plan = factors.plan(weights, limits)
        if self._plan is not None and self._plan.products <= limits.iterate_first:
            self._eliminate(self._plan)

    @property
    def method(self) -> str:
        """How the chain is solved: `elimination` or `iteration`."""
        return "iteration" if self._eliminated is None else "elimination"

    def left(self, start: Array) -> Certified:
        """Return u with u G = start; both: (n,)."""
        return self._solve(start, left=True)

    def right(self, reward: Array, reward_low: Array | None = None) -> Certified:
        """Return x with G x = reward; both: (n,); `reward_low` is what rounding it lost."""
        return self._solve(reward, left=False, given_low=reward_low)

    def _eliminate(self, how: Plan) -> Factors:
        from tracerisk.prm.other_models.markov.large import factors

        self._eliminated = factors.eliminate(self._weights, how, self._label, self._kind)
        return self._eliminated

    def _solve(self, given: Array, *, left: bool, given_low: Array | None = None) -> Certified:
        eliminated = self._eliminated
        if eliminated is None:
            iterated = self._iterate(given, left=left, given_low=given_low)
            if iterated is not None:
                return iterated
            assert self._plan is not None
            eliminated = self._eliminate(self._plan)
        solver = eliminated.left if left else eliminated.right
        return self._certifier.certify(
            given, solver, left=left, rounds=2, positive=True, given_low=given_low
        )

    def _iterate(self, given: Array, *, left: bool, given_low: Array | None) -> Certified | None:
        """Return an iteration's certified result, or `None` where elimination is to be used."""
        from tracerisk.prm.other_models.markov.large import iteration

        trial = self._plan is not None
        steps = iteration.TRIAL_STEPS if trial else iteration.STEPS
        result = iteration.Iteration(self._weights, steps)
        try:
            certified = self._certifier.certify(
                given,
                result.left if left else result.right,
                left=left,
                rounds=iteration.ROUNDS,
                positive=False,
                given_low=given_low,
            )
            bound = certified.bound
            reached = f"a relative error of {bound:.0e}" if math.isfinite(bound) else "no bound"
        except iteration.NotConvergedError as error:
            bound, reached = math.inf, f"a residual of {error}"
        if bound <= (_TRUSTED if trial else _BOUND):
            return certified
        if trial:
            return None
        raise TooLargeError(
            f"a chain of {self._weights.size} transient states: the fill-in of elimination "
            f"exceeds its budget, and iteration reached {reached} instead of a relative error of "
            f"{_BOUND:.0e}; merge states, or raise the budget of elimination"
        )


def solver_of(
    ways: Sequence[Mapping[int, float]], slack: Sequence[float], label: Label, kind: str
) -> WeightSolver:
    """Return what solves a chain of the given weights; see `Elimination`.

    `label` gives the words for a state by its index, `kind` what a weight is, for messages.
    Raises ModelError when a state is left with less than the smallest normal double.
    """
    if len(ways) <= SMALL and sum(map(len, ways)) <= SMALL_WAYS:
        # The count of products, and so the way taken, is the same on every machine.
        kept = [{target: p for target, p in row.items() if p > 0.0} for row in ways]
        try:
            return Elimination(Pattern(label, kept, kind, _SMALL_PRODUCTS), kept, slack)
        except FilledInError:
            pass  # elimination with arrays is faster
    from tracerisk.prm.other_models.markov.large.factors import Weights

    rows = [
        sorted((target, p) for target, p in row.items() if p > 0.0 and target != state)
        for state, row in enumerate(ways)
    ]
    counts = np.array([len(row) for row in rows], dtype=np.int64)
    weights = Weights(
        indptr=np.concatenate((np.zeros(1, np.int64), np.cumsum(counts))),
        indices=np.array([target for row in rows for target, _ in row], dtype=np.int32),
        data=np.array([p for row in rows for _, p in row], dtype=np.float64),
        slack=np.array(slack, dtype=np.float64),
        slack_low=np.zeros(len(slack)),
        ends=np.ones(len(slack), np.int32),
    )
    return _ListSolver(CertifiedSolver(weights, label, kind))


class _ListSolver:
    """A large chain that is asked for lists of numbers."""

    def __init__(self, solver: CertifiedSolver) -> None:
        self._solver = solver

    def left(self, start: Sequence[float]) -> list[float]:
        tolist: list[float] = self._solver.left(np.array(start, dtype=float)).values.tolist()
        return tolist

    def right(self, reward: Sequence[float]) -> list[float]:
        tolist: list[float] = self._solver.right(np.array(reward, dtype=float)).values.tolist()
        return tolist
