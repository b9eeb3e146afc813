"""Uniform random numbers by strata, which follow from a seed and a key alone."""

from __future__ import annotations

from typing import TYPE_CHECKING
from zlib import crc32

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.arrays import np

if TYPE_CHECKING:
    from numpy.random import Generator
    from numpy.typing import NDArray

    from tracerisk.prm.numbers.distributions import Samples


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

    def uniform(self, key: str) -> Samples:
        """Return the uniform numbers of one deviate: (size,)."""
        return stratified(generator_of(key, self._seed), self.size)


def generator_of(key: str, seed: int) -> Generator:
    """Return the generator of a deviate's numbers, from the seed and the key alone."""
    text = key.encode()
    return np.random.default_rng([seed, crc32(text), len(text), *text])


def stratified(generator: Generator, size: int) -> Samples:
    """Return uniform numbers within (0, 1), one in each of `size` equal strata: (size,)."""
    return within(generator.permutation(size), generator)


def within(strata: NDArray[np.int64], generator: Generator) -> Samples:
    """Return a uniform number in each of the strata, which are numbered from 0 on: (n,)."""
    size = len(strata)
    samples: Samples = (strata + generator.random(size)) / size
    # The ends themselves have no quantile.
    tiny = np.finfo(np.float64)
    return np.clip(samples, tiny.tiny, 1.0 - tiny.epsneg)
