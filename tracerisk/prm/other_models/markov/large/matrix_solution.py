"""What a chain given as a matrix comes to from one entry: arrays by state."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.markov.cycles import CycleFigures
from tracerisk.prm.other_models.markov.large.certificate import Certified
from tracerisk.prm.other_models.markov.large.pattern import Array, gathered, row_sums_into

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.matrix_chain import MatrixChain
    from tracerisk.prm.other_models.markov.solver import CertifiedSolver


_ROUNDING = 2.0**-53


@dataclass(frozen=True, slots=True, eq=False)
class MatrixSolution:
    """A chain of n states solved from one of them; all arrays are (n,).

    Formulas as in `ChainSolution`.
    """

    chain: MatrixChain
    """The chain that was solved."""
    entry: int
    """Index of the state in which it starts."""
    _solver: CertifiedSolver
    """Solver of the chain's equations, with bounds of its errors."""
    _stay: Certified
    """Expected visits over the sum of the row, by transient state, (n_transient,)."""

    @property
    def method(self) -> str:
        """How the chain was solved: `elimination` or `iteration`."""
        return self._solver.method

    @property
    def error_bound(self) -> float:
        """A proven bound of the relative error of each of the visits above 1e-250.

        Infinite where none could be proven: after elimination in chains that are absorbed so
        seldom that it does not show in twice the working precision.
        """
        # Three roundings: of the sum of a row, of a state's weight and of their product; the
        # bound holds the second.
        return self._stay.bound + 2.0 * _ROUNDING

    def expected_visits(self) -> Array:
        """Return how often each transient state is visited, the start counted as a visit."""
        return self._full(self._stay.values * self.chain.totals)

    def absorption(self) -> Array:
        """Return the probability of ending in each absorbing state; zero for transient ones."""
        return self._into(self.chain.absorbing)

    def absorption_from_each(self, targets: Iterable[int | str]) -> Array:
        """Return from each state the probability of ending in one of `targets`.

        Raises ModelError when a target is not an absorbing state.
        """
        return self.certified_absorption_from_each(targets).values

    def certified_absorption_from_each(self, targets: Iterable[int | str]) -> Certified:
        """Return `absorption_from_each` with a bound of its relative error.

        Raises ModelError when a target is not an absorbing state.
        """
        chain = self.chain
        chosen = chain.chosen(targets)
        reward, low = row_sums_into(chain.rows, chosen, chain.transient)
        certified = self._solver.right(reward, low)
        return Certified(self._full(certified.values) + chosen, certified.bound)

    def expected_steps(self) -> float:
        """Return the mean number of steps until the chain is absorbed."""
        return float(self.expected_visits().sum())

    def expected_time(self, durations: Any) -> float:
        """Return the mean time until the chain is absorbed.

        durations: (n,) or one number, the mean time of a visit, in any unit.
        Raises ModelError when a duration is negative or not finite.
        """
        return float((self.expected_visits() * self._durations(durations)).sum())

    def expected_time_from_each(self, durations: Any) -> Array:
        """Return from each state the mean time until the chain is absorbed.

        Raises ModelError as `expected_time` does.
        """
        chain = self.chain
        times = self._durations(durations)[chain.transient] * chain.totals
        return self._full(self._solver.right(times).values)

    def expected_time_given(self, targets: Iterable[int | str], durations: Any) -> float:
        """Return the mean time until absorption, given that it ends in one of `targets`.

        Raises ModelError as `expected_time` does, for a target that is not an absorbing state, and
        when the targets are never reached.
        """
        times = self._durations(durations)
        reached = self.absorption_from_each(targets)
        if reached[self.entry] == 0.0:
            raise ModelError("the targets are never reached; the time until then is undefined")
        share = reached / reached[self.entry]
        return float((self.expected_visits() * share * times).sum())

    def per_time(self, targets: Iterable[int | str], durations: Any) -> float:
        """Return how often chains end in one of `targets` per unit of time, run after run.

        Raises ModelError as `expected_time` does, for a target that is not an absorbing state, and
        when the runs take no time.
        """
        length = self.expected_time(durations)
        if length == 0.0:
            raise ModelError(
                "the mean time to absorption is 0: no visit has a duration; give one above 0"
            )
        return float(self._into(self.chain.chosen(targets)).sum()) / length

    def cycles(self, targets: Iterable[int | str]) -> CycleFigures:
        """Return the figures of one cycle, from the entry until it is next visited.

        Raises ModelError when a target is not an absorbing state.
        """
        chosen = self.chain.chosen(targets)
        only = np.zeros(self.chain.size, np.bool_)
        only[self.entry] = True
        visits = float(self.expected_visits()[self.entry])
        failure = float(self._into(chosen).sum())
        end = float(self._into(self.chain.absorbing & ~chosen).sum())
        back = float(self._into(only)[self.entry])
        return CycleFigures(failure / visits, end / visits, back / visits)

    def _into(self, chosen: Array) -> Array:
        chain = self.chain
        return gathered(chain.rows, chosen, chain.transient, self._stay.values)

    def _full(self, values: Array) -> Array:
        full = np.zeros(self.chain.size)
        full[self.chain.transient] = values
        return full

    def _durations(self, durations: Any) -> Array:
        times = np.broadcast_to(np.asarray(durations, dtype=np.float64), (self.chain.size,))
        if not np.all((times >= 0.0) & (times < np.inf)):
            wrong = int(np.flatnonzero(~((times >= 0.0) & (times < np.inf)))[0])
            raise ModelError(
                f"duration of state {wrong}: {float(times[wrong])!r} is not a time; give 0 or more"
            )
        return times
