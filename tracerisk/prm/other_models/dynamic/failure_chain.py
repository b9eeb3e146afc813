"""The probability that a Markov chain in continuous time has failed by a time.

Uniformisation: A. Jensen, "Markoff chains as an aid in the study of Markoff processes",
Skandinavisk Aktuarietidskrift 36 (1953). The weights are taken from their greatest outwards, as by
B. Fox, P. Glynn, "Computing Poisson probabilities", CACM 31 (1988). All terms are positive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tracerisk.errors import TooLargeError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

WORK_LIMIT = 5_000_000_000
"""The most products of a transition and a step: about a minute."""
STEP = 2_000
"""What a step costs beside its transitions, in such products."""
STIFF = 1_000.0
DENSE = 400
"""From so many events of the fastest state on, chains of so many states are solved by doubling."""
SMALL = 200_000
"""Up to so many of them plain Python is faster than loading NumPy."""
NEGLIGIBLE = 1e-17
"""What is left of a series when it ends, relative to its sum."""


@dataclass(frozen=True, slots=True)
class FailureChain:
    """A chain in continuous time that fails when it enters state 0, which nothing leaves."""

    states: int
    """Number of states."""
    initial: tuple[tuple[int, float], ...]
    """Initial distribution, ((state, probability), ...)."""
    transitions: tuple[tuple[int, int, float], ...]
    """Transitions ((source, target, rate), ...), rates in [1/h]."""
    _fastest: float = field(init=False, repr=False, compare=False)
    """Greatest total rate out of a state [1/h]."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "_fastest", max(self._leaving(), default=0.0))

    def failed_by(self, time_h: float) -> Probability:
        """Return the probability of having entered state 0 within a time, [h].

        Relative error of both halves below 1e-12; of chains of more than 400 states while the
        fastest rate times the time stays below a thousand, and growing with that product beyond.
        Raises TooLargeError when that product times the number of transitions outgrows the budget.
        """
        events = self._fastest * time_h
        if not events < math.inf:
            raise TooLargeError(
                f"the rates of a chain of {self.states} states overflow in a mission of "
                f"{time_h:g} h; take the fastest events out of the group"
            )
        if events > STIFF and self.states <= DENSE:
            return self._failed_by_doubling(time_h)
        steps = events + 10.0 * math.sqrt(events) + 30.0
        each = len(self.transitions) + self.states
        if not steps * (each + STEP) <= WORK_LIMIT:
            raise TooLargeError(
                f"a chain of {self.states} states with {events:.3g} events of its fastest state "
                f"in the mission needs {steps * (each + STEP):.3g} products; allowed: "
                f"{WORK_LIMIT:.3g}; shorten the mission, or take the fastest events out of the "
                "group"
            )
        work = steps * each
        shares = self._shares() if work <= SMALL else self._shares_in_arrays()
        return _mixed(events, shares)

    def _failed_by_doubling(self, time_h: float) -> Probability:
        """Return the same from the matrix of a short time, squared again and again.

        Rows are made to sum to one again by their greater part: so the small entries keep their
        relative precision over any number of squarings, and nothing else is subtracted (own
        derivation, after W. Grassmann, M. Taksar, D. Heyman, Operations Research 33, 1985).
        """
        doublings = max(math.ceil(math.log2(self._fastest * time_h)), 0)
        short = math.ldexp(time_h, -doublings)
        rates = np.zeros((self.states, self.states))
        for source, target, rate in self.transitions:
            rates[source, target] += rate * short
        leaving = rates.sum(axis=1)
        fastest = float(leaving.max())
        jumps = (rates + np.diag(fastest - leaving)) / fastest
        term = np.eye(self.states) * math.exp(-fastest)
        matrix = term.copy()
        for count in range(1, 40):
            term = term @ jumps * (fastest / count)
            matrix += term
        for _ in range(doublings):
            _sum_to_one(matrix)
            matrix = matrix @ matrix
        _sum_to_one(matrix)
        end = sum(share * matrix[state] for state, share in self.initial)
        return Probability(float(end[0]), float(end[1:].sum()))

    def _leaving(self) -> list[float]:
        rates: list[list[float]] = [[] for _ in range(self.states)]
        for source, _, rate in self.transitions:
            rates[source].append(rate)
        # A sum beyond all numbers is infinite: fsum raises an error.
        return [math.fsum(values) if sum(values) < math.inf else math.inf for values in rates]

    def _steps(self) -> tuple[list[float], list[float]]:
        """Return the chance to stay in each state at a step, and that of each transition."""
        fastest = self._fastest or 1.0
        staying = [max(fastest - rate, 0.0) / fastest for rate in self._leaving()]
        return staying, [rate / fastest for _, _, rate in self.transitions]

    def _shares(self) -> Iterator[tuple[float, float]]:
        """Yield the failed and the surviving share after 0, 1, 2... steps."""
        staying, chances = self._steps()
        moves = [
            (source, target, chance)
            for (source, target, _), chance in zip(self.transitions, chances, strict=True)
        ]
        now = [0.0] * self.states
        for state, share in self.initial:
            now[state] += share
        while True:
            yield now[0], math.fsum(now[1:])
            following = [share * stay for share, stay in zip(now, staying, strict=True)]
            for source, target, chance in moves:
                following[target] += now[source] * chance
            now = following

    def _shares_in_arrays(self) -> Iterator[tuple[float, float]]:
        """Yield the same, for larger chains."""
        staying, chances = map(np.array, self._steps())
        sources = np.array([source for source, _, _ in self.transitions], dtype=np.intp)
        targets = np.array([target for _, target, _ in self.transitions], dtype=np.intp)
        now = np.zeros(self.states)
        for state, share in self.initial:
            now[state] += share
        while True:
            yield float(now[0]), float(now[1:].sum())
            now = now * staying + np.bincount(
                targets, weights=now[sources] * chances, minlength=self.states
            )


def _sum_to_one(matrix: Array) -> None:
    """Set the diagonal of a stochastic matrix from the other entries, where it is the greater."""
    staying = matrix.diagonal().copy()
    np.fill_diagonal(matrix, 0.0)
    moving = matrix.sum(axis=1)
    np.fill_diagonal(matrix, np.where(moving < 0.5, 1.0 - moving, staying))


def _mixed(mean: float, shares: Iterator[tuple[float, float]]) -> Probability:
    """Return the failed and the surviving share after a Poisson number of steps."""
    peak = int(mean)
    before = _weights_down_from(peak, mean)
    failed = survived = total = 0.0
    weight = 1.0
    for count, (lost, left) in enumerate(shares):
        if count <= peak:
            weight = before[count]
        else:
            weight *= mean / count
        failed += weight * lost
        survived += weight * left
        total += weight
        if count >= peak:
            # What follows is less than a geometric series of these ratios.
            rest = weight * mean / (count + 1 - mean)
            if rest <= NEGLIGIBLE * total and (
                rest * left <= NEGLIGIBLE * survived and rest * (lost + left) <= NEGLIGIBLE * failed
            ):
                break
            if weight == 0.0:
                break
    return Probability(min(failed / total, 1.0), min(survived / total, 1.0))


def _weights_down_from(peak: int, mean: float) -> Sequence[float]:
    """Return the weights of 0 to `peak` steps, that of `peak` being 1."""
    weights = [1.0] * (peak + 1)
    for count in range(peak, 0, -1):
        weights[count - 1] = weights[count] * count / mean
    return weights
