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
from tracerisk.prm.expressions.evaluation import Names, definition_of
from tracerisk.prm.expressions.node import Expression, Reference

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


class Sampling:
    """Samples many expressions over the same names, each name once."""

    def __init__(self, names: Names, mission_time_h: float, draws: Draws) -> None:
        self._names = names
        self._mission_time_h = mission_time_h
        self._draws = draws
        self._known: dict[str, Array] = {}

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
        from tracerisk.prm.numbers.arrays import np

        results: list[Array] = []
        opened: dict[str, None] = {}
        ranks: dict[str, int] = {}
        size = self._draws.size
        stack: list[tuple[Expression, str, bool]] = [(expression, f"event:{owner}", False)]
        while stack:
            node, home, ready = stack.pop()
            if isinstance(node, Reference):
                name = node.name
                if ready:
                    self._known[name] = results[-1]
                    del opened[name]
                elif name in self._known:
                    results.append(self._known[name])
                else:
                    found = definition_of(name, self._names, opened)
                    if isinstance(found, Expression):
                        opened[name] = None
                        stack += [(node, home, True), (found, f"parameter:{name}", False)]
                    else:
                        results.append(np.full(size, float(found)))
                continue
            if node.arguments and not ready:
                stack.append((node, home, True))
                stack.extend((argument, home, False) for argument in reversed(node.arguments))
                continue
            count = len(results) - len(node.arguments)
            arguments = results[count:]
            if isinstance(node, Deviate):
                rank = ranks[home] = ranks.get(home, -1) + 1
                uniform = self._draws.uniform(f"{home}:{rank}")
                values = node.quantiles(arguments, uniform)
            else:
                values = node.values(arguments, self._mission_time_h, size)
            results[count:] = [values]
        return results[0]
