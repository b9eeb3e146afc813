"""Draws of uncertain inputs, all at once or, where they are many, in blocks of bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.distributions import Distribution, Lognormal
from tracerisk.prm.numbers.strata import generator_of, stratified, within

if TYPE_CHECKING:
    from numpy.random import Generator
    from numpy.typing import NDArray

    Places = NDArray[np.int64]
    Samples = NDArray[np.float64]

MOST_FITTED = 4_000_000
"""How many values of inputs are held at once; of more inputs only the leading ones are."""

MOST_TOGETHER = 250
"""How many inputs have their shares fitted together, at most."""

MOST_DRAWN = 20_000_000
"""How many values one block may hold."""

_STRATA = 65_536
"""How many uniform numbers a block has at least, for its inputs to take theirs from."""

_TOGETHER = 64
"""How many inputs are put into order, or added up, at a time."""

_CHANCE = 16.0
"""A squared correlation counts as real from this many times its mean under chance."""


@dataclass(frozen=True, slots=True)
class UncertainInput:
    """A parameter that is drawn."""

    value: float
    """Point value, in the unit of the parameter."""
    distribution: Distribution
    """Distribution of the parameter, possibly relative to the point value."""
    is_probability: bool = True
    """Whether drawn values above 1 are set to 1."""

    @property
    def law(self) -> Hashable:
        """What inputs of the same quantiles have in common, but for their scale."""
        if isinstance(self.distribution, Lognormal):
            return self.distribution
        if isinstance(self.distribution, Hashable):
            return self.distribution, self.value
        return id(self.distribution), self.value

    @property
    def scale(self) -> float:
        """By what the quantiles of the law are multiplied."""
        return self.value if isinstance(self.distribution, Lognormal) else 1.0

    def of_law(self, uniform: Samples) -> Samples:
        """Return the quantiles of the law at uniform numbers."""
        value = 1.0 if isinstance(self.distribution, Lognormal) else self.value
        return self.distribution.quantiles(uniform, value)

    def values(self, uniform: Samples) -> tuple[Samples, int]:
        """Return the values at uniform numbers, and how many were above one and are taken so."""
        quantiles = self.distribution.quantiles(uniform, self.value)
        if not self.is_probability:
            return quantiles, 0
        cut = int((quantiles > 1.0).sum())
        return np.minimum(quantiles, 1.0) if cut else quantiles, cut

    def levels(self, percentiles: Sequence[float]) -> tuple[float, ...]:
        """Return the percentiles of the distribution."""
        array, _ = self.values(np.array(percentiles) / 100.0)
        return tuple(map(float, array))


class InputDraws:
    """The draws of all inputs: a Latin hypercube, or one for each block where inputs are many.

    The numbers of an input follow from the seed, its name and the blocks' size alone.
    Those of a block are taken from one table of uniform numbers, one in each of 65,536 strata or
    more: an input takes one of each of its own strata, in an order of its own. So the inputs of
    one distribution share the work of its quantiles, and two inputs have the same number once in
    65,536 draws.
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

    def blocks(self) -> Iterator[tuple[tuple[str, ...], Samples]]:
        """Yield the values of all inputs, block by block: names (k,), values (k, n).

        A block is overwritten by the next one. What is cut is counted.
        """
        laws: dict[object, list[str]] = {}
        for name, uncertain_input in self.inputs.items():
            laws.setdefault(uncertain_input.law, []).append(name)
        names = tuple(name for group in laws.values() for name in group)
        makers = [generator_of(_key(name), self._seed) for name in names]
        room = np.empty((len(names), max(self._sizes)))
        for number, size in enumerate(self._sizes):
            block = room[:, :size]
            table = self._table(number, size)
            first = 0
            for group in laws.values():
                values = None
                if len(group) * size > len(table):
                    values = self.inputs[group[0]].of_law(table)
                for start in range(first, first + len(group), _TOGETHER):
                    rows = range(start, min(start + _TOGETHER, first + len(group)))
                    places = _places([makers[row] for row in rows], size, len(table))
                    for row, place in zip(rows, places, strict=True):
                        self._put(names[row], block[row], place, table, values)
                first += len(group)
            yield names, block

    def _put(
        self, name: str, row: Samples, place: Places, table: Samples, values: Samples | None
    ) -> None:
        """Write the values at some places of a table; `values` are the law's at every place."""
        each = self.inputs[name]
        if values is None:
            row[:], cut = each.values(table[place])
            self.cut[name] += cut
            return
        np.take(values, place, out=row, mode="clip")
        if each.scale != 1.0:
            row *= each.scale
        if each.is_probability and each.scale * values[-1] > 1.0:
            self.cut[name] += int((row > 1.0).sum())
            np.minimum(row, 1.0, out=row)

    def whole(self, names: Sequence[str]) -> dict[str, Samples]:
        """Return all values of some inputs."""
        makers = [generator_of(_key(name), self._seed) for name in names]
        if self.are_many:
            parts = []
            for number, size in enumerate(self._sizes):
                table = self._table(number, size)
                parts.append(table[_places(makers, size, len(table))])
            uniform = np.concatenate(parts, axis=1)
        else:
            uniform = np.stack([stratified(maker, self._samples) for maker in makers])
        arrays = {}
        for name, row in zip(names, uniform, strict=True):
            arrays[name], self.cut[name] = self.inputs[name].values(row)
        return arrays

    def _table(self, number: int, size: int) -> Samples:
        """Return the uniform numbers that a block takes its own from, in order."""
        count = size << _finer(size)
        return within(np.arange(count), generator_of(f"block:{number}", self._seed))


def _finer(size: int) -> int:
    """Return log2 of the number of parts into which a table splits each of `size` strata."""
    return max(0, (_STRATA - 1).bit_length() - (size - 1).bit_length())


def _places(makers: Sequence[Generator], size: int, count: int) -> Places:
    """Return a place in a table of `count` numbers for each of `size` strata, in random order.

    A row for each maker: (k, size). The lower bits of random words are set to a place each, and
    the words sorted, so that the upper ones make the order.
    """
    lower = np.uint64((1 << (count - 1).bit_length()) - 1)
    finer = np.uint64((1 << _finer(size)) - 1)
    words = np.empty((len(makers), size), dtype=np.uint64)
    for row, maker in zip(words, makers, strict=True):
        row[:] = maker.bit_generator.random_raw(size)
    words &= ~lower | finer
    words |= np.arange(size, dtype=np.uint64) << np.uint64(_finer(size))
    words.sort(axis=1)
    words &= lower
    return words.view(np.int64)


def _key(name: str) -> str:
    return f"parameter:{name}:0"


def in_blocks(
    figure: Callable[[Mapping[str, Samples]], Samples], drawn: InputDraws
) -> tuple[Samples, dict[str, float]]:
    """Return the figure of all draws, and the share of the spread that is linear in each input.

    That is the squared correlation, or zero where it may be chance.
    """
    results: list[Samples] = []
    scale = 0.0
    names: tuple[str, ...] = ()
    sums = np.zeros((3, len(drawn.inputs)))
    for names, block in drawn.blocks():
        results.append(figure(dict(zip(names, block, strict=True))))
        scale = scale or float(results[0].max()) or 1.0
        y = results[-1] / scale
        # Sums are taken of numbers near one, for the square of 1e-200 underflows to zero.
        units = np.array([drawn.inputs[name].value or 1.0 for name in names])
        for start in range(0, len(names), _TOGETHER):
            rows = slice(start, start + _TOGETHER)
            x = block[rows] / units[rows, None]
            sums[0, rows] += x.sum(axis=1)
            sums[1, rows] += np.einsum("ij,ij->i", x, x)
            sums[2, rows] += np.einsum("ij,j->i", x, y)
    whole = np.concatenate(results)
    y = whole / scale
    count = len(whole)
    first, square, joint = sums / count
    spread = (square - first**2) * float(y.var())
    covariance = joint - first * float(y.mean())
    shares = np.where(spread > 0.0, covariance**2 / np.where(spread > 0.0, spread, 1.0), 0.0)
    shares = np.where(shares > _CHANCE / count, shares, 0.0)
    return whole, dict(zip(names, map(float, shares), strict=True))
