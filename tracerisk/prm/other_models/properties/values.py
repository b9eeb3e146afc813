"""The values of paths, rewards and the long run, in each state of a chain.

Probabilities are sums of products of probabilities: nothing is subtracted. What is certain or
impossible follows from the arrows alone, and is 1 or 0 exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from tracerisk.prm.other_models.formats.explicit_chain import ChainKind, ExplicitChain
from tracerisk.prm.other_models.markov.accumulated import time_within, visits_within
from tracerisk.prm.other_models.markov.solver import solver_of
from tracerisk.prm.other_models.markov.stationary import stationary
from tracerisk.prm.other_models.markov.steps import after_steps
from tracerisk.prm.other_models.markov.uniformisation import after_time
from tracerisk.prm.other_models.properties.graph import reaching, recurrent_classes, sources_of

Sets = Sequence[bool]


@dataclass(slots=True)
class ChainValues:
    """A chain and what its questions share.

    Sets and values are lists with an entry per state. Times are steps of a dtmc, and in the unit
    of the rates of a ctmc.
    """

    chain: ExplicitChain
    """The chain as it was read."""
    rows: list[dict[int, float]] = field(init=False)
    """Probability or rate by target of each state, (n_states,); rows of a dtmc sum to 1."""
    _sources: list[list[int]] | None = None
    """States from which each state is entered, (n_states,); `None` until first needed."""
    _classes: list[list[int]] | None = None
    """Recurrent classes, lists of states; `None` until first needed."""

    def __post_init__(self) -> None:
        discrete = self.discrete
        self.rows = []
        for state, row in enumerate(self.chain.rows):
            kept = {target: p for target, p in row.items() if p > 0.0}
            if discrete:
                total = math.fsum(kept.values())
                kept = {target: p / total for target, p in kept.items()} or {state: 1.0}
            self.rows.append(kept)

    @property
    def discrete(self) -> bool:
        """Whether the chain goes by steps."""
        return self.chain.kind is ChainKind.DTMC

    def until(self, left: Sets, right: Sets) -> list[float]:
        """Return the probability of coming to `right` through states of `left` alone."""
        sources = self._sources_of()
        ends = [state for state, holds in enumerate(right) if holds]
        onward = [a and not b for a, b in zip(left, right, strict=True)]
        possible = reaching(sources, ends, onward)
        never = [state for state, holds in enumerate(possible) if not holds]
        doubtful = reaching(sources, never, onward)
        value = [float(b or not flag) for b, flag in zip(right, doubtful, strict=True)]
        open_states = [
            state
            for state, flag in enumerate(doubtful)
            if flag and possible[state] and not right[state]
        ]
        self._solve(open_states, value, [0.0] * len(value))
        return value

    def always(self, holds: Sets) -> list[float]:
        """Return the probability that `holds` is never left."""
        # Else it is left sooner or later, almost surely: all depends on coming where it is kept.
        return self.until(holds, self._kept(holds))

    def weak_until(self, left: Sets, right: Sets) -> list[float]:
        """Return the probability of staying in `left`, for ever or until `right`."""
        either = [a or b for a, b in zip(left, right, strict=True)]
        sources = self._sources_of()
        lost = [state for state, holds in enumerate(either) if not holds]
        kept = reaching(sources, lost, [not b and a for a, b in zip(left, right, strict=True)])
        return self.until(left, [b or not flag for b, flag in zip(right, kept, strict=True)])

    def following(self, holds: Sets) -> list[float]:
        """Return the probability that `holds` after the next move."""
        values = []
        for state, row in enumerate(self.rows):
            total = math.fsum(row.values())
            into = math.fsum(p for target, p in row.items() if holds[target])
            # A state of a ctmc without a way out stays what it is.
            values.append(into / total if total else float(holds[state]))
        return values

    def expected(self, holds: Sets, earned: Sequence[float]) -> list[float]:
        """Return the mean sum of what is earned before `holds`; infinite where it may never."""
        sources = self._sources_of()
        everywhere = [True] * len(holds)
        ends = [state for state, hold in enumerate(holds) if hold]
        possible = reaching(sources, ends, everywhere)
        never = [state for state, flag in enumerate(possible) if not flag]
        doubtful = reaching(sources, never, [not hold for hold in holds])
        value = [math.inf if flag else 0.0 for flag in doubtful]
        sure = [s for s, hold in enumerate(holds) if not hold and not doubtful[s]]
        self._solve(sure, value, earned)
        return value

    def total(self, earned: Sequence[float]) -> list[float]:
        """Return the mean sum of what is ever earned."""
        rich = [
            s for class_ in self._classes_of() for s in class_ if any(earned[t] for t in class_)
        ]
        endless = reaching(self._sources_of(), rich, [True] * len(earned))
        done = {state for class_ in self._classes_of() for state in class_}
        value = [math.inf if flag else 0.0 for flag in endless]
        self._solve(
            [s for s in range(len(earned)) if s not in done and not endless[s]], value, earned
        )
        return value

    def long_run(self, worth: Sequence[float]) -> list[float]:
        """Return the long-run mean of what the states are worth."""
        value = [0.0] * len(worth)
        done = set()
        for states in self._classes_of():
            done.update(states)
            index = {state: number for number, state in enumerate(states)}
            rows = [{index[t]: p for t, p in self.rows[s].items()} for s in states]
            chosen = [state for state in states if worth[state]]
            if not chosen:
                continue
            if all(worth[state] == 1.0 for state in states):
                mean = 1.0
            else:
                shares = stationary(rows, self._labels(states), self._kind)
                mean = math.fsum(shares[index[state]] * worth[state] for state in chosen)
            for state in states:
                value[state] = mean
        rest = [state for state in range(len(worth)) if state not in done]
        if worth and all(value[state] == 1.0 for state in done):
            return [1.0] * len(worth)
        self._solve(rest, value, [0.0] * len(worth))
        return value

    def within(self, left: Sets, right: Sets, low: float, high: float, state: int) -> float:
        """Return the probability of `left` until `right`, this between two times, from a state.

        `high` may be infinite. Raises TooLargeError where there are too many moves in the time.
        """
        size = len(self.rows)
        start = [0.0] * (size + 1)
        start[state] = 1.0
        if low > 0.0:
            start = self._staying(left, start, low)
        if math.isinf(high):
            onward = self.until(left, right)
            return math.fsum(p * v for p, v in zip(start, onward, strict=False) if p)
        stopped = [{} if right[s] or not left[s] else row for s, row in enumerate(self.rows)]
        after = self.after(start, high - low, stopped)
        return math.fsum(p for p, holds in zip(after, right, strict=False) if holds)

    def after(
        self, start: list[float], time: float, rows: Sequence[dict[int, float]] | None = None
    ) -> list[float]:
        """Return the probability of each state after a time, and last of being out of all."""
        moves = [*(self.rows if rows is None else rows), {}]
        if not self.discrete:
            return after_time(moves, start, time)
        steps = [row or {state: 1.0} for state, row in enumerate(moves)]
        return after_steps(steps, start, int(time))

    def always_within(self, holds: Sets, high: float, state: int) -> float:
        """Return the probability that `holds` is not left up to a time, from a state."""
        start = [float(number == state) for number in range(len(self.rows) + 1)]
        rows = [row if holds[s] else {} for s, row in enumerate(self.rows)]
        after = self.after(start, high, rows)
        return math.fsum(p for p, hold in zip(after, holds, strict=False) if hold)

    def earned_within(self, earned: Sequence[float], time: float, state: int) -> float:
        """Return the mean sum of what is earned up to a time, from a state."""
        start = [float(number == state) for number in range(len(self.rows))]
        if self.discrete:
            stays = visits_within(self.rows, start, int(time))
        else:
            stays = time_within(self.rows, start, time)
        return math.fsum(stay * value for stay, value in zip(stays, earned, strict=True) if value)

    def earned_at(self, worth: Sequence[float], time: float, state: int) -> float:
        """Return the mean of what the state at a time is worth, from a state."""
        start = [float(number == state) for number in range(len(self.rows) + 1)]
        after = self.after(start, time)
        return math.fsum(p * value for p, value in zip(after, worth, strict=False) if value)

    def _staying(self, left: Sets, start: list[float], time: float) -> list[float]:
        """Return where a chain is at a time, before which it was in `left`; else it is lost."""
        lost = len(self.rows)
        rows = [row if left[state] else {} for state, row in enumerate(self.rows)]
        if not self.discrete:
            return _without(self.after(start, time, rows), left, lost)
        # Where the last step leads need not be in `left`.
        before = _without(self.after(start, time - 1.0, rows), left, lost)
        return self.after(before, 1.0)

    def _kept(self, holds: Sets) -> list[bool]:
        """Return the states of `holds` from which no other can be reached."""
        outside = [state for state, hold in enumerate(holds) if not hold]
        leaving = reaching(self._sources_of(), outside, holds)
        return [not flag for flag in leaving]

    def _solve(self, states: Sequence[int], value: list[float], earned: Sequence[float]) -> None:
        """Fill in the values of `states`, from which the others, whose values stand, are reached.

        A state's value is the mean of those that follow, and what it earns.
        """
        if not states:
            return
        index = {state: number for number, state in enumerate(states)}
        ways, slack, given = [], [], []
        for state in states:
            row = self.rows[state]
            ways.append({index[t]: p for t, p in row.items() if t in index and t != state})
            outside = [(t, p) for t, p in row.items() if t not in index]
            slack.append(math.fsum(p for _, p in outside))
            given.append(math.fsum((earned[state], *(p * value[t] for t, p in outside))))
        solver = solver_of(ways, slack, self._labels(states), self._kind)
        for state, result in zip(states, solver.right(given), strict=True):
            value[state] = float(result)

    def _labels(self, states: Sequence[int]) -> Callable[[int], str]:
        return lambda number: f"'{self.chain.names[states[number]]}'"

    @property
    def _kind(self) -> str:
        return "probability" if self.discrete else "rate"

    def _sources_of(self) -> list[list[int]]:
        if self._sources is None:
            self._sources = sources_of(self.rows)
        return self._sources

    def _classes_of(self) -> list[list[int]]:
        if self._classes is None:
            self._classes = recurrent_classes(self.rows)
        return self._classes


def _without(found: list[float], left: Sets, lost: int) -> list[float]:
    """Return a distribution with what is outside of `left` moved to the place `lost`."""
    kept = [p if holds else 0.0 for p, holds in zip(found, left, strict=False)]
    gone = math.fsum(p for p, holds in zip(found, left, strict=False) if not holds)
    return [*kept, found[lost] + gone]
