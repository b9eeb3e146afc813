"""The loops of diagrams and of families of sets at two speeds: compiled, or as Python on lists.

Both give the same numbers to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from tracerisk.prm.compiled import library
from tracerisk.prm.trees.bdd import families as sets
from tracerisk.prm.trees.bdd import force, kernel, sweeps, thinning

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@dataclass(frozen=True, slots=True)
class Loops:
    """The functions of `kernel`, `sweeps`, `thinning`, `force` and `families`, at one speed.

    The last fields make the sequences that the functions take.
    """

    build: Callable[..., int]
    """`kernel.build`: makes the decision diagram of gates."""
    extract: Callable[..., int]
    """`kernel.extract`: copies the nodes below an edge."""
    sweep: Callable[..., None]
    """`sweeps.sweep`: probability of each node."""
    edge_gains: Callable[..., int]
    """`sweeps.edge_gains`: probability of each high edge less the low edge."""
    derivatives: Callable[..., None]
    """`sweeps.derivatives`: derivative of the root's probability by each variable."""
    differences: Callable[..., None]
    """`sweeps.differences`: change of each node between two assignments."""
    thinned: Callable[..., int]
    """`thinning.thinned`: smaller function that implies a given one."""
    collect: Callable[..., None]
    """`kernel.collect`: frees nodes that no edge needs."""
    draw: Callable[..., None]
    """`force.draw`: order of variables by rounds of FORCE."""
    minimal_solutions: Callable[..., int]
    """`families.minimal_solutions`: minimal sets that make an edge true."""
    compact: Callable[..., int]
    """`families.compact`: frees nodes that a family does not need."""
    totals: Callable[..., None]
    """`families.totals`: sum of the products of each family's sets."""
    greatest: Callable[..., None]
    """`families.greatest`: greatest product of one set of each family."""
    lightest: Callable[..., None]
    """`families.lightest`: least weight of one set of each family."""
    integers: Callable[[int], Any]
    """Makes a sequence of so many zeros, integers."""
    floats: Callable[[int], Any]
    """Makes a sequence of so many zeros, floats."""
    listed: Callable[[Any], Any]
    """Makes a sequence of given integers."""
    listed_floats: Callable[[Any], Any]
    """Makes a sequence of given floats."""
    sweep_many: Callable[..., None] | None = None
    """Probability of each node for many samples at once; `None` where not compiled."""


@cache
def fastest_loops() -> Loops:
    """Return the loops compiled, or as Python where they were not."""
    return plain_loops() if library.library() is None else _compiled_loops()


@cache
def plain_loops() -> Loops:
    """Return the loops as Python."""
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
