"""Samples of expressions, for many draws at once.

A deviate is drawn once for each name whose definition holds it, however often that is referred to;
one that stands in an event's own expression is that event's alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.other_models.expressions.deviates import Deviate
from tracerisk.prm.other_models.expressions.evaluation import Names, Walk
from tracerisk.prm.other_models.expressions.node import Expression

if TYPE_CHECKING:
    from tracerisk.prm.other_models.expressions.node import Array


class Draws(Protocol):
    """A source of uniform numbers."""

    @property
    def size(self) -> int:
        """The number of draws."""
        ...

    def uniform(self, key: str) -> Array:
        """Return the uniform numbers in (0, 1) of one deviate: (size,), equal for equal keys."""
        ...


def sample(
    expression: Expression, names: Names, mission_time_h: float, draws: Draws, owner: str = ""
) -> Array:
    """Return the values of the expression: (draws.size,); see `Sampling.of`."""
    return Sampling(names, mission_time_h, draws).of(expression, owner)


class Sampling(Walk):
    """Samples many expressions over the same names, each name once."""

    def __init__(self, names: Names, mission_time_h: float, draws: Draws) -> None:
        super().__init__(names, mission_time_h)
        self._draws = draws
        self._owner = ""
        self._ranks: dict[str, int] = {}

    @property
    def sampled(self) -> Mapping[str, Array]:
        """The values of the names that were needed so far."""
        return self._known

    def of(self, expression: Expression, owner: str = "") -> Array:
        """Return the values of an expression: (size,).

        `owner` names what the expression belongs to: deviates in expressions of different owners
        are independent. A deviate's key is `parameter:name` or `event:owner`, with its rank there.
        Raises ModelError as `evaluate` does.
        """
        self._owner, self._ranks = owner, {}
        value: Array = self._values((expression,))[0]
        return value

    def _number(self, number: float) -> Array:
        return np.full(self._draws.size, float(number))

    def _of(self, node: Expression, arguments: list[Array], opened: Mapping[str, None]) -> Array:
        if not isinstance(node, Deviate):
            return node.values(arguments, self._mission_time_h, self._draws.size)
        home = f"parameter:{[*opened][-1]}" if opened else f"event:{self._owner}"
        rank = self._ranks[home] = self._ranks.get(home, -1) + 1
        return node.quantiles(arguments, self._draws.uniform(f"{home}:{rank}"))
