"""The loops of diagrams at two speeds: as Python on lists, or compiled by numba on arrays.

numba is imported by `compiled_loops` only: a diagram of up to a few thousand nodes is built sooner
than numba starts.
Both give the same numbers to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar, cast

from tracerisk.dependencies import is_installed, require_large
from tracerisk.prm.bdd import kernel, sweeps

_Function = TypeVar("_Function", bound=Callable[..., Any])


@dataclass(frozen=True, slots=True)
class Loops:
    """The functions of `kernel` and `sweeps`, and how the sequences that they take are made."""

    build: Callable[..., int]
    extract: Callable[..., int]
    compact: Callable[..., int]
    sweep: Callable[..., None]
    sweep_many: Callable[..., None]
    edge_gains: Callable[..., int]
    derivatives: Callable[..., None]
    differences: Callable[..., None]
    integers: Callable[[int], Any]
    floats: Callable[[int], Any]
    listed: Callable[[list[int]], Any]
    listed_floats: Callable[[list[float]], Any]


PLAIN = Loops(
    kernel.build,
    kernel.extract,
    kernel.compact,
    sweeps.sweep,
    sweeps.sweep_many,
    sweeps.edge_gains,
    sweeps.derivatives,
    sweeps.differences,
    integers=lambda size: [0] * size,
    floats=lambda size: [0.0] * size,
    listed=list,
    listed_floats=list,
)


@cache
def compiled_loops() -> Loops:
    """Return the loops compiled; each is compiled when first called, then kept on disk."""
    from tracerisk.prm.numbers.arrays import np

    return Loops(
        compiled_by_numba(kernel.build),
        compiled_by_numba(kernel.extract),
        compiled_by_numba(kernel.compact),
        compiled_by_numba(sweeps.sweep),
        compiled_by_numba(sweeps.sweep_many),
        compiled_by_numba(sweeps.edge_gains),
        compiled_by_numba(sweeps.derivatives),
        compiled_by_numba(sweeps.differences),
        integers=lambda size: np.zeros(size, dtype=np.int32),
        floats=lambda size: np.zeros(size, dtype=np.float64),
        listed=lambda items: np.array(items, dtype=np.int32),
        listed_floats=lambda items: np.array(items, dtype=np.float64),
    )


def fastest_loops() -> Loops:
    """Return the loops compiled, or as Python where numba is not installed."""
    return compiled_loops() if is_installed("numba") else PLAIN


def compiled_by_numba(function: _Function) -> _Function:
    """Return a function compiled when first called, and kept on disk where a folder can be.

    Raises DependencyError where numba is not installed.
    """
    require_large("numba")
    import numba

    try:
        return cast(_Function, numba.njit(cache=True)(function))
    except RuntimeError:
        # No folder for the cache can be written: neither beside the package nor the user's.
        return cast(_Function, numba.njit(function))
