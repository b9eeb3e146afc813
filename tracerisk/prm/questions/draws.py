"""Draws of uncertain inputs, all at once or, where they are many, in blocks of bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.prm.numbers.distributions import Distribution

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Samples = NDArray[np.float64]

MOST_FITTED = 4_000_000
"""How many values of inputs are held at once; of more inputs only the leading ones are."""

MOST_TOGETHER = 250
"""How many inputs have their shares fitted together, at most."""

MOST_DRAWN = 10_000_000
"""How many values one block may hold."""

_CHANCE = 16.0
"""From how many times its mean on a squared correlation is not taken for chance."""


@dataclass(frozen=True, slots=True)
class UncertainInput:
    """A parameter that is drawn: its point value, its distribution, whether it ends at one."""

    value: float
    distribution: Distribution
    is_probability: bool = True

    def values(self, uniform: Samples) -> tuple[Samples, int]:
        """Return the values at uniform numbers, and how many were above one and are taken so."""
        from tracerisk.prm.numbers.arrays import np

        found = self.distribution.quantiles(uniform, self.value)
        if not self.is_probability:
            return found, 0
        cut = int((found > 1.0).sum())
        return np.minimum(found, 1.0) if cut else found, cut

    def levels(self, percentiles: Sequence[float]) -> tuple[float, ...]:
        """Return the percentiles of the distribution."""
        from tracerisk.prm.numbers.arrays import np

        found, _ = self.values(np.array(percentiles) / 100.0)
        return tuple(map(float, found))


class InputDraws:
    """The draws of all inputs: a Latin hypercube, or one for each block where inputs are many.

    The numbers of an input follow from the seed, its name and the blocks' size alone.
    `fitted` inputs at most may be held whole; `cut` counts the values that were above one.
    """

    def __init__(self, inputs: Mapping[str, UncertainInput], samples: int, seed: int) -> None:
        """Prepare the draws."""
        self.inputs, self._samples, self._seed = inputs, samples, seed
        self.fitted = max(1, min(MOST_TOGETHER, MOST_FITTED // samples))
        self.are_many = len(inputs) > self.fitted
        size = max(64, MOST_DRAWN // len(inputs)) if self.are_many else samples
        whole, rest = divmod(samples, size)
        self._sizes = [size] * whole + [rest] * (rest > 0)
        self.cut = dict.fromkeys(inputs, 0)

    def blocks(self) -> Iterator[dict[str, Samples]]:
        """Yield the values of all inputs, block by block; what is cut is counted."""
        from tracerisk.prm.expressions.sampling import generator_of, stratified

        makers = {name: generator_of(_key(name), self._seed) for name in self.inputs}
        for size in self._sizes:
            found = {}
            for name, each in self.inputs.items():
                found[name], cut = each.values(stratified(makers[name], size))
                self.cut[name] += cut
            yield found

    def whole(self, names: Sequence[str]) -> dict[str, Samples]:
        """Return all values of some inputs."""
        from tracerisk.prm.expressions.sampling import generator_of, stratified
        from tracerisk.prm.numbers.arrays import np

        found = {}
        for name in names:
            maker = generator_of(_key(name), self._seed)
            uniform = np.concatenate([stratified(maker, size) for size in self._sizes])
            found[name], self.cut[name] = self.inputs[name].values(uniform)
        return found


def _key(name: str) -> str:
    return f"parameter:{name}:0"


def in_blocks(
    figure: Callable[[Mapping[str, Samples]], Samples], drawn: InputDraws
) -> tuple[Samples, dict[str, float]]:
    """Return the figure of all draws, and the share of each input that is linear in it.

    That is the squared correlation, or zero where it may be chance.
    """
    from tracerisk.prm.numbers.arrays import np

    # Sums are taken of numbers near one, for the squares of 1e-200 are no numbers.
    units = np.array([each.value or 1.0 for each in drawn.inputs.values()])
    results: list[Samples] = []
    scale = 0.0
    sums = np.zeros((len(units), 3))
    for block in drawn.blocks():
        results.append(figure(block))
        scale = scale or float(results[0].max()) or 1.0
        y = results[-1] / scale
        for row, unit, x in zip(sums, units, block.values(), strict=True):
            row += (x.sum() / unit, x @ (x / unit) / unit, x @ y / unit)
    whole = np.concatenate(results)
    y = whole / scale
    count = len(whole)
    first, square, joint = sums.T / count
    spread = (square - first**2) * float(y.var())
    covariance = joint - first * float(y.mean())
    shares = np.where(spread > 0.0, covariance**2 / np.where(spread > 0.0, spread, 1.0), 0.0)
    shares = np.where(shares > _CHANCE / count, shares, 0.0)
    return whole, dict(zip(drawn.inputs, map(float, shares), strict=True))
