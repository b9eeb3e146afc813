"""How the place of a small chain after some time changes with its transitions, and by how much.

A chain in continuous time is taken in steps by uniformisation (A. Jensen, 1953): after a time t
it has made k steps of a chain in discrete time with the Poisson probability of k events at Lambda
t, where Lambda exceeds every rate of leaving.
All terms are positive, so that rare states keep their relative precision.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tracerisk.errors import TooLargeError
from tracerisk.prm.numbers.probability import Probability, mean_of
from tracerisk.prm.other_models.expressions.rules import apart
from tracerisk.prm.other_models.markov.steps import multiplied

SPARE = 1.25
"""Lambda over the greatest rate of leaving: no state's probability of staying is a small rest."""
_NEGLIGIBLE = 1e-80
_MOST_NUMBERS = 5_000_000
"""How many numbers may be held: steps times states and transitions."""


@dataclass(frozen=True, slots=True)
class Place:
    """A transition whose value may change."""

    source: int
    """Number of the state that it leaves."""
    target: int
    """Number of the state that it leads to."""
    rest: Mapping[int, float]
    """States that lose what the transition gains, with their shares, by number."""
    scale: float
    """Change of the step's probability per change of the transition's value."""


@dataclass(frozen=True, slots=True)
class Steps:
    """A chain in discrete time, and the probability of each number of steps."""

    rows: Sequence[Mapping[int, float]]
    """Probability of each successor by number, (n_states,)."""
    places: Sequence[Place]
    """Transitions that are inputs, (n_inputs,)."""
    weights: Sequence[float]
    """Probability of making 0, 1, 2... steps."""
    start: int
    """Number of the state in which the chain starts."""
    targets: frozenset[int]
    """Numbers of the states whose probability is the figure."""


class Occupied:
    """A chain step by step, with all that the derivatives of being in the targets need."""

    def __init__(self, steps: Steps) -> None:
        self._steps = steps
        self._forward = _forward(steps)
        self._backward: list[list[Probability]] | None = None

    def gradient(self) -> list[float]:
        """Return the derivative of the figure by each place."""
        return self._coefficients(self)

    def change(self, low: Occupied, changes: Sequence[float]) -> float:
        """Return the figure less that of `low`, a chain of the same states, steps and places.

        sum_k pi_k (P - P0) c0_(k+1): where this chain is after k steps, and what the other makes
        of where it goes (a telescoping sum, own derivation).
        """
        return math.fsum(
            coefficient * value
            for coefficient, value in zip(self._coefficients(low), changes, strict=True)
        )

    def _coefficients(self, other: Occupied) -> list[float]:
        steps = self._steps
        backward = other._chances()
        coefficients = []
        for place, rest in zip(steps.places, (p.rest for p in other._steps.places), strict=True):
            parts = []
            for k in range(len(steps.weights) - 1):
                here = self._forward[k][place.source]
                if here == 0.0:
                    continue
                chances = backward[k + 1]
                mean = mean_of((share, chances[state]) for state, share in rest.items())
                parts.append(here * apart(chances[place.target], mean))
            coefficients.append(place.scale * math.fsum(parts))
        return coefficients

    def _chances(self) -> list[list[Probability]]:
        """Return c_k: what being in a state after k steps adds to the figure from then on."""
        if self._backward is None:
            steps = self._steps
            size = len(steps.rows)
            ends = [
                Probability(1.0, 0.0) if state in steps.targets else Probability(0.0, 1.0)
                for state in range(size)
            ]
            now = [Probability(0.0, 0.0)] * size
            backward = []
            for weight in reversed(steps.weights):
                now = [
                    Probability(
                        weight * ends[state].p
                        + math.fsum(p * now[target].p for target, p in row.items()),
                        weight * ends[state].q
                        + math.fsum(p * now[target].q for target, p in row.items()),
                    )
                    for state, row in enumerate(steps.rows)
                ]
                backward.append(now)
            self._backward = backward[::-1]
        return self._backward


def _forward(steps: Steps) -> list[list[float]]:
    """Return pi_k: where the chain is after k steps."""
    now = [float(state == steps.start) for state in range(len(steps.rows))]
    forward = [now]
    for _ in steps.weights[1:]:
        now = multiplied(now, steps.rows)
        forward.append(now)
    return forward


def check_steps(count: float, rows: Sequence[Mapping[int, float]]) -> None:
    """Raise TooLargeError when so many steps of a chain are more than can be held."""
    numbers = count * (len(rows) + sum(len(row) for row in rows))
    if numbers > _MOST_NUMBERS:
        raise TooLargeError(
            f"about {count:.3g} steps of {len(rows)} states; allowed: {_MOST_NUMBERS:.0e} "
            "numbers, steps times states and transitions; give a shorter time, or slower rates"
        )


def poisson_weights(mean: float, least: int) -> list[float]:
    """Return the probabilities of 0, 1, 2... events, up to those that are negligible.

    From the greatest on by ratios, so that nothing underflows that matters; at least `least`.
    """
    mode = int(mean)
    below = [1.0]
    for k in range(mode, 0, -1):
        below.append(below[-1] * k / mean)
    weights = below[::-1]
    while len(weights) <= mode + least or weights[-1] > _NEGLIGIBLE:
        weights.append(weights[-1] * mean / len(weights))
        if weights[-1] == 0.0:
            break
    total = math.fsum(weights)
    return [weight / total for weight in weights]


def uniformised(
    rates: Sequence[Mapping[int, float]], fastest: float
) -> tuple[list[dict[int, float]], float]:
    """Return the chain in discrete time of a chain's rates, and Lambda, [1/h].

    `fastest` is the greatest rate of leaving that Lambda must exceed.
    """
    pace = SPARE * fastest if fastest > 0.0 else 1.0
    rows = []
    for state, row in enumerate(rates):
        stay = (pace - math.fsum(row.values())) / pace
        rows.append({state: stay} | {target: rate / pace for target, rate in row.items()})
    return rows, pace
