"""What an absorbing chain comes to from one entry, by the names of its states."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.markov.cycles import CycleFigures
from tracerisk.prm.other_models.markov.solver import WeightSolver


@dataclass(frozen=True, slots=True)
class ChainSolution:
    """An absorbing chain after elimination, and the state in which it starts."""

    transitions: Mapping[str, Mapping[str, float]]
    """Probability, or rate in continuous time, by transient state and target."""
    absorbing: tuple[str, ...]
    """Names of the absorbing states."""
    entry: str
    """Name of the transient state in which the chain starts."""
    _solver: WeightSolver
    """Solver of the chain's equations."""
    _totals: tuple[float, ...]
    """Factor from the solver's values to visits, by transient state: the sum of its weights."""

    def expected_visits(self) -> dict[str, float]:
        """Return how often each transient state is visited, the start counted as a visit."""
        return {
            state: value * total
            for (state, value), total in zip(self._stay().items(), self._totals, strict=True)
        }

    def absorption(self) -> dict[str, float]:
        """Return for each absorbing state the probability of ending there."""
        parts: dict[str, list[float]] = {state: [] for state in self.absorbing}
        for state, stay in self._stay().items():
            for target, weight in self.transitions[state].items():
                if target in parts:
                    parts[target].append(stay * weight)
        return {state: math.fsum(terms) for state, terms in parts.items()}

    def absorption_from_each(self, targets: Iterable[str]) -> dict[str, float]:
        """Return from each transient state the probability of ending in one of `targets`.

        Raises ModelError when a target is not an absorbing state.
        """
        chosen = self._chosen(targets)
        reward = [
            math.fsum(p for target, p in row.items() if target in chosen)
            for row in self.transitions.values()
        ]
        return dict(zip(self.transitions, self._solver.right(reward), strict=True))

    def expected_steps(self) -> float:
        """Return the mean number of steps until the chain is absorbed."""
        return math.fsum(self.expected_visits().values())

    def expected_time(self, durations: Mapping[str, float]) -> float:
        """Return the mean time until the chain is absorbed.

        `durations` gives the mean time of one visit of each transient state, in any unit.
        Raises ModelError when a duration is missing, unknown, negative or not finite.
        """
        times = self._durations(durations)
        return math.fsum(n * times[state] for state, n in self.expected_visits().items())

    def expected_time_from_each(self, durations: Mapping[str, float]) -> dict[str, float]:
        """Return from each transient state the mean time until the chain is absorbed.

        Raises ModelError as `expected_time` does.
        """
        times = self._durations(durations)
        reward = [times[s] * total for s, total in zip(times, self._totals, strict=True)]
        return dict(zip(times, self._solver.right(reward), strict=True))

    def expected_time_given(self, targets: Iterable[str], durations: Mapping[str, float]) -> float:
        """Return the mean time until absorption, given that it ends in one of `targets`.

        A visit of s is followed by such an end with the probability h_s of it from s, so the
        time is sum_s v_s h_s d_s / h_entry (own derivation, docs/theory.md#markov-chains).
        Raises ModelError as `expected_time` does, for a target that is not an absorbing state, and
        when the targets are never reached.
        """
        times = self._durations(durations)
        chosen = self._chosen(targets)
        reached = self.absorption_from_each(chosen)
        if reached[self.entry] == 0.0:
            raise ModelError(
                f"{', '.join(sorted(chosen)) or 'no target'} is never reached from "
                f"'{self.entry}'; the time until then is undefined"
            )
        # Division comes first: far from the targets the product of the two may be no double.
        return math.fsum(
            visits * (reached[state] / reached[self.entry]) * times[state]
            for state, visits in self.expected_visits().items()
        )

    def per_time(self, targets: Iterable[str], durations: Mapping[str, float]) -> float:
        """Return how often chains end in one of `targets` per unit of time, run after run.

        Failures per operating hour, with the failure states as targets and durations in hours:
        the probability of ending there over the mean time until the chain ends
        (renewal-reward theorem).
        Raises ModelError as `expected_time` does, for a target that is not an absorbing state, and
        when the runs take no time.
        """
        length = self.expected_time(durations)
        if length == 0.0:
            raise ModelError(
                "the mean time to absorption is 0: no visit has a duration; give one above 0"
            )
        chosen = self._chosen(targets)
        ends = math.fsum(p for state, p in self.absorption().items() if state in chosen)
        return ends / length

    def cycles(self, targets: Iterable[str]) -> CycleFigures:
        """Return the figures of one cycle, from the entry until it is next visited.

        Cycles are alike and independent: with n the expected visits of the entry, a cycle ends
        in `targets` with 1/n of the probability that the chain does (own derivation).
        Raises ModelError when a target is not an absorbing state.
        """
        chosen = self._chosen(targets)
        stays = self._stay()
        index = list(stays).index(self.entry)
        visits = stays[self.entry] * self._totals[index]
        ends = self.absorption()
        back = math.fsum(
            stay * self.transitions[state].get(self.entry, 0.0) for state, stay in stays.items()
        )
        return CycleFigures(
            failure=math.fsum(p for state, p in ends.items() if state in chosen) / visits,
            end=math.fsum(p for state, p in ends.items() if state not in chosen) / visits,
            back=back / visits,
        )

    def _stay(self) -> dict[str, float]:
        """Return each state's expected visits over the sum of its weights."""
        start = [0.0] * len(self.transitions)
        start[list(self.transitions).index(self.entry)] = 1.0
        return dict(zip(self.transitions, self._solver.left(start), strict=True))

    def _chosen(self, targets: Iterable[str]) -> set[str]:
        chosen = set()
        for target in targets:
            if target not in self.absorbing:
                raise ModelError(
                    f"'{target}' is not an absorbing state; {one_of(self.absorbing, target)}"
                )
            chosen.add(target)
        return chosen

    def _durations(self, durations: Mapping[str, float]) -> dict[str, float]:
        for state, time in durations.items():
            if state not in self.transitions:
                raise ModelError(
                    f"duration of '{state}': no such state; {one_of(self.transitions, state)}"
                )
            if not 0.0 <= time < math.inf:
                raise ModelError(f"duration of '{state}': {time!r} is not a time; give 0 or more")
        missing = [state for state in self.transitions if state not in durations]
        if missing:
            raise ModelError(f"no duration for {', '.join(missing)}; give each state one")
        return {state: durations[state] for state in self.transitions}
