"""The loops of diagrams and of families of sets at two speeds: compiled, or as Python on lists.

Both give the same numbers to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from tracerisk.prm.compiled import library

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@dataclass(frozen=True, slots=True)
class Loops:
    """The functions of `kernel`, `sweeps`, `thinning`, `force` and `families`.

    And how the sequences that they take are made.
    """

    build: Callable[..., int]
    extract: Callable[..., int]
    sweep: Callable[..., None]
    edge_gains: Callable[..., int]
    derivatives: Callable[..., None]
    differences: Callable[..., None]
    thinned: Callable[..., int]
    collect: Callable[..., None]
    draw: Callable[..., None]
    minimal_solutions: Callable[..., int]
    compact: Callable[..., int]
    totals: Callable[..., None]
    greatest: Callable[..., None]
    lightest: Callable[..., None]
    integers: Callable[[int], Any]
    floats: Callable[[int], Any]
    listed: Callable[[Any], Any]
    listed_floats: Callable[[Any], Any]
    sweep_many: Callable[..., None] | None = None


@cache
def fastest_loops() -> Loops:
    """Return the loops compiled, or as Python where they were not."""
    return plain_loops() if library.library() is None else _compiled_loops()


@cache
def plain_loops() -> Loops:
    """Return the loops as Python."""
    from tracerisk.prm.trees.bdd import families as sets
    from tracerisk.prm.trees.bdd import force, kernel, sweeps, thinning

    return Loops(
        kernel.build,
        kernel.extract,
        sweeps.sweep,
        sweeps.edge_gains,
        sweeps.derivatives,
        sweeps.differences,
        thinning.thinned,
        kernel.collect,
        force.draw,
        sets.minimal_solutions,
        sets.compact,
        sets.totals,
        sets.greatest,
        sets.lightest,
        integers=lambda size: [0] * size,
        floats=lambda size: [0.0] * size,
        listed=list,
        listed_floats=list,
    )


def _compiled_loops() -> Loops:
    loop = library.loop
    return Loops(
        loop("build", "nn" + 9 * "i", int),
        loop("extract", "nn" + 5 * "i", int),
        loop("sweep", "iiidddd"),
        loop("edge_gains", "iiiddddidiidid", int),
        loop("derivatives", "niiiddddd"),
        loop("differences", "iiiddddd"),
        loop("thinned", "nniidddddii", int),
        loop("collect", 5 * "i"),
        loop("draw", "niiddid"),
        loop("minimal_solutions", "niiiiin" + 9 * "i", int),
        loop("compact", "nniiii", int),
        loop("totals", "iiidd"),
        loop("greatest", "iiidd"),
        loop("lightest", "iiiini"),
        integers=library.integers,
        floats=library.floats,
        listed=library.listed,
        listed_floats=library.listed_floats,
        sweep_many=loop("sweep_many", "niiidddd"),
    )
