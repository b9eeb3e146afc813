"""Samples of expressions, for many draws at once.

A deviate is drawn once for each name whose definition holds it, however often that is referred to;
one that stands in an event's own expression is that event's alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol
from zlib import crc32

from tracerisk.errors import ModelError
from tracerisk.prm.expressions.deviates import Deviate
from tracerisk.prm.expressions.evaluation import Names, Walk
from tracerisk.prm.expressions.node import Expression

if TYPE_CHECKING:
    import numpy as np
    from numpy.random import Generator
    from numpy.typing import NDArray

    from tracerisk.prm.expressions.node import Array


class Draws(Protocol):
    """A source of uniform numbers."""

    @property
    def size(self) -> int:
        """The number of draws."""
        ...

    def uniform(self, key: str) -> Array:
        """Return the uniform numbers in (0, 1) of one deviate: (size,), equal for equal keys."""
        ...


class LatinHypercube:
    """Uniform numbers of which each of `size` equal strata of (0, 1) holds one.

    They follow from the seed and the key alone, in whatever order the keys come
    (McKay, Beckman and Conover 1979).
    """

    def __init__(self, size: int, seed: int) -> None:
        if size < 1:
            raise ModelError(f"{size} draws; give 1 or more")
        self.size = size
        self._seed = seed

    def uniform(self, key: str) -> Array:
        """Return the uniform numbers of one deviate: (size,)."""
        return stratified(generator_of(key, self._seed), self.size)


def generator_of(key: str, seed: int) -> Generator:
    """Return the generator of a deviate's numbers, from the seed and the key alone."""
    from tracerisk.prm.numbers.arrays import np

    text = key.encode()
    return np.random.default_rng([seed, crc32(text), len(text), *text])


def stratified(generator: Generator, size: int) -> Array:
    """Return uniform numbers within (0, 1), one in each of `size` equal strata: (size,)."""
    return within(generator.permutation(size), generator)


def within(strata: NDArray[np.int64], generator: Generator) -> Array:
    """Return a uniform number in each of the strata, which are numbered from 0 on: (n,)."""
    from tracerisk.prm.numbers.arrays import np

    size = len(strata)
    found: Array = (strata + generator.random(size)) / size
    # The ends themselves have no quantile.
    tiny = np.finfo(np.float64)
    return np.clip(found, tiny.tiny, 1.0 - tiny.epsneg)


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
        found: Array = self._values((expression,))[0]
        return found

    def _number(self, number: float) -> Array:
        from tracerisk.prm.numbers.arrays import np

        return np.full(self._draws.size, float(number))

    def _of(self, node: Expression, arguments: list[Array], opened: Mapping[str, None]) -> Array:
        if not isinstance(node, Deviate):
            return node.values(arguments, self._mission_time_h, self._draws.size)
        home = f"parameter:{[*opened][-1]}" if opened else f"event:{self._owner}"
        rank = self._ranks[home] = self._ranks.get(home, -1) + 1
        return node.quantiles(arguments, self._draws.uniform(f"{home}:{rank}"))
