"""The family of the minimal solutions of one module, by the literals of its inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tracerisk.errors import TooLargeError
from tracerisk.prm.trees.bdd import families
from tracerisk.prm.trees.bdd.diagram import Diagram
from tracerisk.prm.trees.bdd.logic import LogicGraph
from tracerisk.prm.trees.bdd.modules import Module
from tracerisk.prm.trees.bdd.speed import Loops, fastest_loops, plain_loops

_MOST_PAIRS = 1 << 22
"""How many pairs are kept where few nodes have many: those of a gate of many inputs."""

NO_SET = 0
EMPTY_SET = 1


@dataclass(frozen=True, slots=True)
class Family:
    """A family of sets of literals, see `tracerisk.prm.trees.bdd.families`."""

    root: int
    """Node of the whole family."""
    literals: tuple[int, ...]
    """Element of each level, (n_levels,)."""
    level: Any
    """Level of each node's element, (n_nodes,) integers."""
    low: Any
    """Node of the sets without the element, (n_nodes,) integers."""
    high: Any
    """Node of the sets with the element, without it, (n_nodes,) integers."""
    loops: Loops
    """Functions that compute on the sequences above, compiled or in Python."""

    @property
    def nodes(self) -> tuple[Any, Any, Any]:
        """The level, low and high node of each node."""
        return self.level, self.low, self.high

    @property
    def size(self) -> int:
        """The number of nodes, the two constants included."""
        return len(self.level)

    def totals(self, values: Mapping[int, float]) -> Any:
        """Return by node the sum over its sets of the products of their literals' values."""
        return self._filled(self.loops.totals, values)

    def greatest(self, values: Mapping[int, float]) -> Any:
        """Return by node the greatest product of the literals' values of one of its sets."""
        return self._filled(self.loops.greatest, values)

    def lightest(self, weights: Mapping[int, int], most: int | None) -> Any:
        """Return by node the least weight of one of its sets; above `most` where it has none."""
        by_level = self.loops.listed([weights[literal] for literal in self.literals])
        integers = self.loops.integers(self.size)
        # More than any set can weigh where there is no limit.
        none = (sum(weights[literal] for literal in self.literals) if most is None else most) + 1
        self.loops.lightest(*self.nodes, by_level, none, integers)
        return integers

    def by_order(
        self, of_literal: Mapping[int, Sequence[float]], most: int | None = None
    ) -> list[float]:
        """Return the sum over its sets of the products of their literals' values, by order.

        `of_literal` gives the same of each literal: (0, p) for an event, one set of order one.
        Orders above `most` are left out.
        """
        sums: list[list[float]] = [[], [1]]
        for node in range(2, self.size):
            factor = of_literal[self.literals[self.level[node]]]
            grown = list(sums[self.low[node]])
            above = sums[self.high[node]]
            size = len(factor) + len(above) - 1
            if most is not None:
                size = min(size, most + 1)
            grown += [0] * (size - len(grown))
            for i, of_factor in enumerate(factor):
                if of_factor:
                    for order, of_above in zip(range(i, size), above, strict=False):
                        grown[order] += of_factor * of_above
            sums.append(grown)
        return sums[self.root]

    def _filled(self, loop: Callable[..., None], values: Mapping[int, float]) -> Any:
        by_level = self.loops.listed_floats([values[literal] for literal in self.literals])
        floats = self.loops.floats(self.size)
        loop(*self.nodes, by_level, floats)
        return floats


def of_conjunction(literals: Sequence[int]) -> Family:
    """Return the family of the one set of all the literals."""
    count = len(literals)
    level = [count, count, *range(count - 1, -1, -1)]
    high = [0, 0, *range(1, count + 1)]
    return Family(count + 1, tuple(literals), level, [0] * (count + 2), high, plain_loops())


def of_disjunction(literals: Sequence[int]) -> Family:
    """Return the family of one set for each of the literals."""
    count = len(literals)
    level = [count, count, *range(count - 1, -1, -1)]
    low = [0, 0, 0, *range(2, count + 1)]
    return Family(count + 1, tuple(literals), level, low, [0, 0] + [1] * count, plain_loops())


def phases(graph: LogicGraph, module: Module) -> dict[int, int] | None:
    """Return for each input of a module the sign with which it makes the root happen.

    `None` where an input stands with both signs: the module is not monotone in it.
    """
    signs = {module.root: 1}
    for gate in reversed(module.gates):
        sign = signs[gate]
        for argument in graph.arguments[gate]:
            number = sign if argument > 0 else -sign
            if signs.setdefault(abs(argument), number) != number:
                return None
    return {node: signs[node] for node in module.inputs}


def of_diagram(
    diagram: Diagram,
    sign: int,
    literals: tuple[int, ...],
    weights: Mapping[int, int],
    most: int | None,
    budget: int,
) -> Family:
    """Return the minimal solutions of a module's diagram, or of its complement (`sign` -1).

    `literals` are what can be in a solution, by level: the input, or its complement; `weights`
    give each literal the least order of what it stands for, and sets that weigh more than `most`
    are left out.
    Raises TooLargeError when more than `budget` nodes are needed.
    """
    rising = [int(literal > 0) for literal in literals]
    heavy = [weights[literal] if most is not None else 0 for literal in literals]
    columns = 1 if most is None else most + 1
    loops = fastest_loops()
    # Each edge may hold a family of its own for each of the weights that are left.
    size = max(2_000, 4 * diagram.size)
    while True:
        size = min(size, budget)
        made = [loops.integers(size) for _ in range(3)]
        used = loops.integers(1)
        root = loops.minimal_solutions(
            diagram.root ^ int(sign < 0),
            *diagram.nodes,
            loops.listed(rising),
            loops.listed(heavy),
            columns - 1,
            loops.integers(2 * diagram.size * columns),
            loops.integers(2 * diagram.size * columns),
            *made,
            loops.integers(1 << (size + size // 4).bit_length()),
            loops.integers(3 << (max(size, min(16 * size, _MOST_PAIRS)) - 1).bit_length()),
            loops.integers(4 * (len(literals) + 3)),
            used,
        )
        if root != families.OUT_OF_NODES:
            count = int(used[0])
            kept = loops.compact(root, count, *made, loops.integers(count))
            # The root is the last of those kept, but for the constants.
            root = root if root <= EMPTY_SET else kept - 1
            level, low, high = (sequence[:kept] for sequence in made)
            return Family(root, literals, level, low, high, loops)
        if size >= budget:
            raise TooLargeError(
                f"the minimal cut sets of a module with {len(literals)} inputs need more than "
                f"{budget} nodes; limit their order (max_order), or give a larger budget"
            )
        size *= 4
