"""Markov chains in continuous time: durations, repair and availability."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracerisk.common.strong_components import reached
from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.markov.chain import (
    MarkovChain,
    check_absorbed,
    check_entry,
    check_targets,
    distinct_names,
    split_rows,
)
from tracerisk.prm.other_models.markov.solution import ChainSolution
from tracerisk.prm.other_models.markov.solver import solver_of
from tracerisk.prm.other_models.markov.stationary import stationary
from tracerisk.prm.other_models.markov.uniformisation import distribution_at


@dataclass(frozen=True, slots=True)
class ContinuousChain:
    """A chain in continuous time: a row of transition rates per state.

    A rate from a state to itself changes nothing.

    Raises ModelError when a name is used twice or unknown, or a rate is negative or not finite.
    """

    rates: Mapping[str, Mapping[str, float]]
    """Rate of going to each target [1/unit of time], by state and target; not listed is zero."""
    absorbing: tuple[str, ...] = ()
    """Names of the states that are never left and have no row; where none is named, all targets
    without a row."""

    def __post_init__(self) -> None:
        if not self.absorbing:
            reached = dict.fromkeys(target for row in self.rates.values() for target in row)
            ends = tuple(state for state in reached if state not in self.rates)
            object.__setattr__(self, "absorbing", ends)
        known = distinct_names(self.rates, self.absorbing)
        for state, row in self.rates.items():
            check_targets(state, row, known, "rate")
            if not 2.0 * sum(row.values()) < math.inf:
                raise ModelError(
                    f"state '{state}': the sum of its rates overflows; give all rates in a "
                    "shorter unit of time"
                )

    def solve(self, entry: str) -> ContinuousSolution:
        """Solve the chain that starts in `entry` until it is absorbed, without a subtraction.

        Raises ModelError when `entry` is not a state with a row, when a state can never be
        absorbed, or when one is left with less than the smallest number of double precision.
        """
        check_entry(entry, self.rates)
        check_absorbed(self.rates, self.absorbing)
        states = tuple(self.rates)
        index = {state: number for number, state in enumerate(states)}
        ways, slack = split_rows(self.rates, index)
        solver = solver_of(ways, slack, lambda state: f"'{states[state]}'", "rate")
        start = [0.0] * len(states)
        start[index[entry]] = 1.0
        times = dict(zip(states, solver.left(start), strict=True))
        visits = tuple(
            math.fsum(p for t, p in row.items() if t != s) for s, row in self.rates.items()
        )
        return ContinuousSolution(
            times, ChainSolution(self.rates, self.absorbing, entry, solver, visits)
        )

    def embedded(self) -> MarkovChain:
        """Return the chain of the states as they follow each other, whatever time they take.

        Raises ModelError when a state can never be absorbed.
        """
        check_absorbed(self.rates, self.absorbing)
        rows = {}
        for state, row in self.rates.items():
            total = math.fsum(rate for target, rate in row.items() if target != state)
            rows[state] = {t: rate / total for t, rate in row.items() if t != state and rate > 0.0}
        return MarkovChain(rows, self.absorbing)

    def transient(self, entry: str, time: float) -> dict[str, float]:
        """Return the probability of each state at `time`, from `entry` at time zero.

        A. Jensen, "Markoff chains as an aid in the study of Markoff processes", Skandinavisk
        Aktuarietidskrift 36 (1953): uniformisation, whose terms are all positive. The Poisson
        weights left out sum to less than 1e-250. For long times the distribution over a
        2^-k-th of the time is squared k times.
        Raises ModelError when `entry` is not a state or `time` is negative or not finite;
        TooLargeError when the chain has more than 2,000 states and moves too often in the time.
        """
        if entry in self.absorbing:
            return {s: float(s == entry) for s in (*self.rates, *self.absorbing)}
        check_entry(entry, self.rates)
        if not 0.0 <= time < math.inf:
            raise ModelError(f"time {time!r}: give a time of 0 or more")
        return distribution_at(self.rates, self.absorbing, entry, time)

    def steady_state(self) -> dict[str, float]:
        """Return the long-run share of time in each state.

        By elimination of all states but one (Grassmann, Taksar, Heyman 1985); states that are
        left for good have a share of zero.
        Raises ModelError when the chain can end up in several sets of states that it never
        leaves: then the share depends on where it starts.
        """
        recurrent = self._recurrent()
        index = {state: number for number, state in enumerate(recurrent)}
        rows = [
            {index[target]: rate for target, rate in self.rates.get(state, {}).items() if rate}
            for state in recurrent
        ]
        shares = dict.fromkeys((*self.rates, *self.absorbing), 0.0)
        values = stationary(rows, lambda state: f"'{recurrent[state]}'", "rate")
        shares.update(zip(recurrent, values, strict=True))
        return shares

    def availability(self, up: Iterable[str]) -> float:
        """Return the long-run share of time in the states `up`.

        Raises ModelError as `steady_state` does, and when a state is unknown.
        """
        chosen = self._known(up)
        return math.fsum(share for s, share in self.steady_state().items() if s in chosen)

    def unavailability(self, up: Iterable[str]) -> float:
        """Return the long-run share of time in all other states, summed, not subtracted.

        Raises ModelError as `availability` does.
        """
        chosen = self._known(up)
        return self.availability(s for s in (*self.rates, *self.absorbing) if s not in chosen)

    def failure_frequency(self, up: Iterable[str]) -> float:
        """Return how often per unit of time the chain leaves the states `up`, in the long run.

        Raises ModelError as `availability` does.
        """
        chosen = self._known(up)
        shares = self.steady_state()
        return math.fsum(
            shares[state] * rate
            for state, row in self.rates.items()
            if state in chosen
            for target, rate in row.items()
            if target not in chosen
        )

    def _known(self, states: Iterable[str]) -> set[str]:
        names = (*self.rates, *self.absorbing)
        chosen = set(states)
        for state in sorted(chosen):
            if state not in names:
                raise ModelError(f"'{state}' is not a state of the chain; {one_of(names, state)}")
        return chosen

    def _recurrent(self) -> list[str]:
        """Return the one set of states that is never left, in order."""
        names = (*self.rates, *self.absorbing)
        if not names:
            raise ModelError("a chain without states has no steady state; give it one state")
        onward = {s: [t for t, r in row.items() if r > 0.0] for s, row in self.rates.items()}
        sources: dict[str, list[str]] = {name: [] for name in names}
        for state, targets in onward.items():
            for target in targets:
                sources[target].append(state)
        # If all states lead to some state, the last root of a search backwards is such a one.
        closed = reached([_last_root(names, sources)], lambda state: onward.get(state, ()))
        joined = reached(closed, sources.__getitem__)
        rest = [name for name in names if name not in joined]
        if rest:
            one, other = min(closed), rest[0]
            raise ModelError(
                f"the steady state depends on the start: '{one}' and '{other}' cannot reach each "
                "other; connect them, or solve for absorption"
            )
        return [name for name in names if name in closed]


@dataclass(frozen=True, slots=True)
class ContinuousSolution:
    """A chain in continuous time that starts in one state, until it is absorbed."""

    _times: Mapping[str, float]
    """Mean total time in each transient state before absorption [unit of time], by name."""
    _solution: ChainSolution
    """The chain after elimination."""

    def expected_times(self) -> dict[str, float]:
        """Return the mean total time in each state before absorption."""
        return dict(self._times)

    def expected_visits(self) -> dict[str, float]:
        """Return how often each state is entered before absorption, the start counted."""
        return self._solution.expected_visits()

    def absorption(self) -> dict[str, float]:
        """Return for each absorbing state the probability of ending there."""
        return self._solution.absorption()

    def absorption_from_each(self, targets: Iterable[str]) -> dict[str, float]:
        """Return from each state the probability of ending in one of `targets`.

        Raises ModelError when a target is not an absorbing state.
        """
        return self._solution.absorption_from_each(targets)

    def expected_time(self) -> float:
        """Return the mean time until absorption."""
        return math.fsum(self._times.values())

    def expected_time_given(self, targets: Iterable[str]) -> float:
        """Return the mean time until absorption, given that it ends in one of `targets`.

        Raises ModelError when a target is not an absorbing state, or none is ever reached.
        """
        chosen = list(targets)
        reached = self.absorption_from_each(chosen)
        entry = self._solution.entry
        if reached[entry] == 0.0:
            raise ModelError(
                f"{', '.join(sorted(chosen)) or 'no target'} is never reached from '{entry}'; "
                "the time until then is undefined"
            )
        return math.fsum(
            time * (reached[state] / reached[entry]) for state, time in self._times.items()
        )

    def per_time(self, targets: Iterable[str]) -> float:
        """Return how often chains end in one of `targets` per unit of time, run after run.

        Raises ModelError when a target is not an absorbing state.
        """
        entry = self._solution.entry
        return self.absorption_from_each(targets)[entry] / self.expected_time()


def _last_root(names: Iterable[str], onward: Mapping[str, list[str]]) -> str:
    """Return the last state from which a search over the whole graph has to start anew."""
    seen: set[str] = set()
    last = ""
    for root in names:
        if root in seen:
            continue
        last = root
        seen.add(root)
        waiting = [root]
        while waiting:
            for target in onward[waiting.pop()]:
                if target not in seen:
                    seen.add(target)
                    waiting.append(target)
    return last
