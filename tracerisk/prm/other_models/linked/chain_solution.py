"""Markov chains within a linked model: solved on pairs, differentiated, compared."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.probability import Probability, mean_of
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.expressions.rules import apart, within
from tracerisk.prm.other_models.linked.elements import LinkedChain
from tracerisk.prm.other_models.linked.links import Absorption, Link, Occupancy
from tracerisk.prm.other_models.linked.occupancy import (
    Occupied,
    Place,
    Steps,
    check_steps,
    poisson_weights,
    uniformised,
)
from tracerisk.prm.other_models.markov import ChainSolution, MarkovChain
from tracerisk.prm.other_models.markov.steps import after_steps
from tracerisk.prm.other_models.markov.uniformisation import after_time

_ROW_TOLERANCE = 1e-9


@dataclass(frozen=True, slots=True)
class Row:
    """The transitions out of a state."""

    explicit: dict[str, int]
    """Place of the transition's value in the inputs, by target."""
    remainder: dict[str, float]
    """Share of what the explicit transitions leave of one, by target."""


@dataclass(frozen=True, slots=True)
class ChainToSolve:
    """A chain made ready for solving."""

    chain: LinkedChain
    """The chain as the model has it."""
    inputs: tuple[Expression, ...]
    """Expressions of the transitions that have one, in order."""
    rows: Mapping[str, Row]
    """Transitions by source state."""

    def check(self, link: Link) -> None:
        """Raise ModelError when a link asks for a state or a time that the chain has not."""
        here = f"{self.chain.key}"
        if not isinstance(link, Absorption | Occupancy):
            raise ModelError(f"{here} has no figure of type {type(link).__name__}")
        allowed = self.chain.states
        if isinstance(link, Absorption):
            if self.chain.time == "continuous":
                raise ModelError(f"{here} is in continuous time; use its occupancy at a time")
            allowed = self.chain.absorbing
        elif (self.chain.time == "discrete") is (link.steps is None) or (
            link.steps is not None and (link.steps < 0 or link.time_h is not None)
        ):
            needed = "a number of steps" if self.chain.time == "discrete" else "a time in hours"
            raise ModelError(
                f"{here} is in {self.chain.time} time; ask for its occupancy after {needed}"
            )
        if not link.states:
            raise ModelError(f"{here}: no state is given; {one_of(allowed)}")
        for state in link.states:
            if state not in allowed:
                kind = "an absorbing state" if isinstance(link, Absorption) else "a state"
                raise ModelError(f"{here}: '{state}' is not {kind}; {one_of(allowed, state)}")

    def solve(self, inputs: Sequence[Probability], mission_time_h: float) -> SolvedChain:
        """Return the chain solved.

        Raises ModelError when a transition is not a probability or rate, a row does not sum to
        one, or some state is never left for an absorbing one.
        """
        return SolvedChain(self, tuple(inputs), mission_time_h)


def chain_to_solve(chain: LinkedChain) -> ChainToSolve:
    """Return a chain made ready for solving."""
    inputs: list[Expression] = []
    rows: dict[str, Row] = {}
    for step in chain.transitions:
        row = rows.setdefault(step.source, Row({}, {}))
        if step.value is None:
            row.remainder[step.target] = float(step.share)
        else:
            row.explicit[step.target] = len(inputs)
            inputs.append(step.value)
    return ChainToSolve(chain, tuple(inputs), rows)


class SolvedChain:
    """A chain solved for one set of its transitions' values."""

    def __init__(
        self, made: ChainToSolve, inputs: tuple[Probability, ...], mission_time_h: float
    ) -> None:
        self._made = made
        self._inputs = inputs
        is_discrete = made.chain.time == "discrete"
        if is_discrete:
            self._inputs = self._probabilities()
        self._mission_time_h = mission_time_h
        self._from_each: dict[tuple[str, ...], dict[str, Probability]] = {}
        self._totals = {
            state: self._row_total(state, row) if is_discrete else 1.0
            for state, row in made.rows.items()
        }
        if not is_discrete:
            self._check_rates()

    def figure(self, link: Link) -> Probability:
        """Return a probability of absorption, or of being in some states at a time."""
        if isinstance(link, Occupancy):
            return self._occupancy(link)
        return self._ending(self._targets(link))[self._made.chain.entry]

    def gradient(self, link: Link) -> Sequence[float]:
        """Return the derivative of the figure by each transition with a value.

        Of an absorption it is v_i (u_j - u_r): the expected visits to the source, and how much
        likelier the targets are from j than from where the probability is taken from, which is
        the remainder or, of a row without one, the row as a whole.
        """
        if isinstance(link, Occupancy):
            return self._occupied(link).gradient()
        ending = self._ending(self._targets(link))
        slopes = [0.0] * len(self._inputs)
        for state, row in self._made.rows.items():
            taken = _mean(row.remainder, ending) if row.remainder else ending[state]
            visits = self._visits[state] / self._totals[state]
            for target, place in row.explicit.items():
                slopes[place] = visits * apart(ending[target], taken)
        return slopes

    def change(self, low: SolvedChain, changes: Sequence[float], link: Link) -> float:
        """Return the figure less that of `low`.

        Subtracting the first-step equations of the two chains and solving for the difference
        gives sum_s v_s sum_j (P_sj - P0_sj) u0_j, with the visits of this chain and the ends of
        the other (own derivation).
        """
        if isinstance(link, Occupancy):
            pace = max(self._fastest, low._fastest)
            return self._occupied(link, pace).change(low._occupied(link, pace), changes)
        ending = low._ending(self._targets(link))
        falls = []
        for state, row in self._made.rows.items():
            taken = _mean(row.remainder, ending) if row.remainder else ending[state]
            grown = [
                changes[place] * apart(ending[target], taken)
                for target, place in row.explicit.items()
                if changes[place]
            ]
            if grown:
                falls.append(self._visits[state] / self._totals[state] * math.fsum(grown))
        return math.fsum(falls)

    @cached_property
    def _solution(self) -> ChainSolution:
        chain = self._made.chain
        rows = {state: self._row(state) for state in self._made.rows}
        try:
            return MarkovChain(rows, chain.absorbing).solve(chain.entry)
        except ModelError as error:
            raise ModelError(f"{chain.key}: {error.message}") from error

    @cached_property
    def _visits(self) -> dict[str, float]:
        return self._solution.expected_visits()

    def _row(self, state: str) -> dict[str, float]:
        row = self._made.rows[state]
        values = {target: self._inputs[place].p for target, place in row.explicit.items()}
        if row.remainder:
            left = self._left(state)
            for target, share in row.remainder.items():
                values[target] = values.get(target, 0.0) + left * share
        return values

    def _left(self, state: str) -> float:
        """Return what the transitions of a state leave of one, from the largest's complement."""
        taken = [self._inputs[place] for place in self._made.rows[state].explicit.values()]
        if not taken:
            return 1.0
        largest = max(range(len(taken)), key=lambda index: taken[index].p)
        rest = (-pair.p for index, pair in enumerate(taken) if index != largest)
        return max(0.0, math.fsum((taken[largest].q, *rest)))

    def _row_total(self, state: str, row: Row) -> float:
        where = f"{self._made.chain.key}, state '{state}'"
        total = math.fsum(self._inputs[place].p for place in row.explicit.values())
        if row.remainder:
            if total > 1.0 + _ROW_TOLERANCE:
                raise ModelError(f"{where}: transitions sum to {total!r} and leave no remainder")
            return 1.0
        if abs(total - 1.0) > _ROW_TOLERANCE:
            raise ModelError(
                f"{where}: its transitions sum to {total!r}; they must sum to 1, or one of them "
                "must be the remainder"
            )
        return total

    def _probabilities(self) -> tuple[Probability, ...]:
        probabilities = list(self._inputs)
        for state, row in self._made.rows.items():
            for target, place in row.explicit.items():
                probability = within(probabilities[place])
                if probability is None:
                    raise ModelError(
                        f"{self._made.chain.key}, state '{state}': probability "
                        f"{probabilities[place].p!r} "
                        f"to '{target}' is outside [0, 1]"
                    )
                probabilities[place] = probability
        return tuple(probabilities)

    def _check_rates(self) -> None:
        for state, row in self._made.rows.items():
            for target, place in row.explicit.items():
                rate = self._inputs[place].p
                if not 0.0 <= rate < math.inf:
                    raise ModelError(
                        f"{self._made.chain.key}, state '{state}': rate {rate!r} to '{target}' "
                        "is not a finite number of 0 or more events per hour"
                    )

    def _targets(self, link: Link) -> tuple[str, ...]:
        assert isinstance(link, Absorption)
        return tuple(state for state in self._made.chain.absorbing if state in link.states)

    def _ending(self, targets: tuple[str, ...]) -> dict[str, Probability]:
        """Return from each state the probability of ending in `targets`, and elsewhere."""
        if targets not in self._from_each:
            chain = self._made.chain
            others = tuple(state for state in chain.absorbing if state not in targets)
            there = self._solution.absorption_from_each(targets)
            elsewhere = self._solution.absorption_from_each(others)
            row = {state: Probability(there[state], elsewhere[state]) for state in there}
            row |= {state: Probability(1.0, 0.0) for state in targets}
            row |= {state: Probability(0.0, 1.0) for state in others}
            self._from_each[targets] = row
        return self._from_each[targets]

    @cached_property
    def _fastest(self) -> float:
        """The greatest rate of leaving a state."""
        return max(
            math.fsum(self._inputs[place].p for place in row.explicit.values())
            for row in self._made.rows.values()
        )

    def _occupancy(self, link: Occupancy) -> Probability:
        """Return the probability of being in some states at a time, and of being elsewhere."""
        states = self._made.chain.states
        start = [float(state == self._made.chain.entry) for state in states]
        if self._made.chain.time == "discrete":
            after = after_steps(self._step_rows(), start, link.steps or 0)
        else:
            after = after_time(self._rates(), start, self._time_of(link))
        there = [p for p, state in zip(after, states, strict=True) if state in link.states]
        rest = [p for p, state in zip(after, states, strict=True) if state not in link.states]
        return Probability(math.fsum(there), math.fsum(rest))

    def _time_of(self, link: Occupancy) -> float:
        return self._mission_time_h if link.time_h is None else link.time_h

    def _step_rows(self) -> list[dict[int, float]]:
        index = {state: place for place, state in enumerate(self._made.chain.states)}
        given = [self._row(state) if state in self._made.rows else {} for state in index]
        return [
            {index[target]: p / self._totals[state] for target, p in row.items()}
            or {index[state]: 1.0}
            for state, row in zip(index, given, strict=True)
        ]

    def _rates(self) -> list[dict[int, float]]:
        index = {state: place for place, state in enumerate(self._made.chain.states)}
        rates: list[dict[int, float]] = [{} for _ in index]
        for state, made in self._made.rows.items():
            for target, place in made.explicit.items():
                rates[index[state]][index[target]] = self._inputs[place].p
        return rates

    def _occupied(self, link: Occupancy, pace: float | None = None) -> Occupied:
        """Return what the derivatives of an occupancy need: the chain step by step."""
        chain = self._made.chain
        index = {state: place for place, state in enumerate(chain.states)}
        scales: dict[str, float]
        if chain.time == "discrete":
            rows = self._step_rows()
            check_steps(link.steps or 0, rows)
            weights = [0.0] * (link.steps or 0) + [1.0]
            scales = {state: 1.0 / total for state, total in self._totals.items()}
        else:
            rows, each = uniformised(self._rates(), self._fastest if pace is None else pace)
            time_h = self._time_of(link)
            check_steps(each * time_h, rows)
            weights = poisson_weights(each * time_h, len(index))
            scales = dict.fromkeys(self._made.rows, 1.0 / each)
        places: list[Place] = [Place(0, 0, {}, 0.0)] * len(self._inputs)
        for state, made in self._made.rows.items():
            rest = {index[target]: share for target, share in made.remainder.items()}
            if not rest:
                # Staying gives way in continuous time; a row that is whole is divided by its sum.
                here = index[state]
                rest = {here: 1.0} if chain.time == "continuous" else dict(rows[here])
            for target, place in made.explicit.items():
                places[place] = Place(index[state], index[target], rest, scales[state])
        targets = frozenset(index[state] for state in link.states)
        return Occupied(Steps(rows, places, weights, index[chain.entry], targets))


def _mean(shares: Mapping[str, float], of: Mapping[str, Probability]) -> Probability:
    return mean_of((share, of[target]) for target, share in shares.items())
