"""The loops on families of sets, on flat sequences, as Python.

`tracerisk/prm/compiled/families.c` has the same functions, which run where they were compiled.

A family is a zero-suppressed diagram (Minato, "Zero-suppressed BDDs for set manipulation in
combinatorial problems", DAC 1993): node 0 is the family of no set, node 1 that of the empty set;
any other holds the sets of its low node, and those of its high node with the element of its level.
Nodes stand after those below them.
Minimal solutions of a decision diagram: Rauzy, "New algorithms for fault trees analysis",
Reliability Engineering and System Safety 40 (1993).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Integers = Any
"""A list of integers, or an array of them."""
Floats = Any
"""A list of floats, or an array of them."""

OUT_OF_NODES = -1


def minimal_solutions(
    root: int,
    level: Integers,
    low: Integers,
    high: Integers,
    rising: Integers,
    weight: Integers,
    most: int,
    needed: Integers,
    family: Integers,
    set_level: Integers,
    set_low: Integers,
    set_high: Integers,
    table: Integers,
    cache: Integers,
    frames: Integers,
    used: Integers,
) -> int:
    """Build the family of the minimal solutions of an edge of a decision diagram; return its node.

    Returns OUT_OF_NODES when it needs more nodes than there is room for.

    root, level, low, high: the decision diagram, see `tracerisk.prm.trees.bdd.kernel`.
    rising: (levels,) whether the function rises with the variable (1), or falls (0): then the
        element stands for its complement.
    weight: (levels,) of each element; a set whose elements weigh more than `most` is left out.
        With weights of zero and `most` zero, none is.
    needed: (2 n_nodes (most + 1)) zeros, scratch.
    family: as `needed`; out, the family of each edge and what its sets may weigh.
    set_level, set_low, set_high: (budget,) out, the nodes of families.
    table: (power of two, over budget) zeros; cache: (3 times a power of two) zeros.
    frames: (4 (levels + 3)) the stack; used: (1) out, how many nodes were made.
    """
    sets = _Families(set_level, set_low, set_high, table, cache, frames)
    columns = most + 1
    set_level[0] = set_level[1] = level[0]
    needed[root * columns + most] = 1
    for node in range(len(level) - 1, 0, -1):
        heavy = weight[level[node]]
        for sign in range(2):
            above, below = _sides(node, sign, low, high, rising[level[node]])
            for room in range(columns):
                if needed[(2 * node + sign) * columns + room]:
                    needed[below * columns + room] = 1
                    if room >= heavy:
                        needed[above * columns + room - heavy] = 1
    for room in range(columns):
        family[room] = 1
        family[columns + room] = 0
    for node in range(1, len(level)):
        here = level[node]
        heavy = weight[here]
        for sign in range(2):
            above, below = _sides(node, sign, low, high, rising[here])
            for room in range(columns):
                place = (2 * node + sign) * columns + room
                if not needed[place]:
                    continue
                rest = family[below * columns + room]
                made = family[above * columns + room - heavy] if room >= heavy else 0
                made = sets.without(made, rest)
                # Add the element to each set that is left; join them to the sets without it.
                if made != OUT_OF_NODES:
                    made = sets.node_of(here, rest, made)
                if made == OUT_OF_NODES:
                    used[0] = sets.count
                    return OUT_OF_NODES
                family[place] = made
    used[0] = sets.count
    return int(family[root * columns + most])


def _sides(node: int, sign: int, low: Integers, high: Integers, is_rising: int) -> tuple[int, int]:
    """Return the edges of a node, or of its complement, with and without its level's element."""
    above, below = high[node] ^ sign, low[node] ^ sign
    return (above, below) if is_rising else (below, above)


@dataclass(slots=True)
class _Families:
    """The nodes of families under construction, with a table to look nodes up.

    The sequences are described in `minimal_solutions`.
    """

    level: Integers
    """Level of each node's element, (budget,)."""
    low: Integers
    """Node of the sets without the element, (budget,)."""
    high: Integers
    """Node of the sets with the element, without it, (budget,)."""
    table: Integers
    """Hash table of node numbers by level, low and high; 0 is free; a power of two long."""
    cache: Integers
    """Results of `without`, three numbers an entry: both operands and the result."""
    frames: Integers
    """Stack of `without`, four numbers a frame, (4 (n_levels + 3),)."""
    count: int = 2
    """Number of nodes made, with the two constants."""

    def node_of(self, level: int, low: int, high: int) -> int:
        """Return the node of a level, made where there is none, or OUT_OF_NODES."""
        if high == 0:
            return low
        mask = len(self.table) - 1
        slot = level * 741457 + low * 12582917 + high * 4256249
        slot = (slot ^ (slot >> 17)) & mask
        while result := self.table[slot]:
            if (self.level[result], self.low[result], self.high[result]) == (level, low, high):
                return int(result)
            slot = (slot + 1) & mask
        node = self.count
        if node >= len(self.level):
            return OUT_OF_NODES
        self.count += 1
        self.table[slot] = node
        self.level[node], self.low[node], self.high[node] = level, low, high
        return node

    def without(self, f: int, g: int) -> int:
        """Return the sets of f that hold no set of g, or OUT_OF_NODES."""
        level, low, high, cache, frames = self.level, self.low, self.high, self.cache, self.frames
        mask = len(cache) // 3 - 1
        depth = 0
        while True:
            if f == 0 or g == 1 or f == g:
                result = 0
            elif g == 0 or f == 1:
                result = f
            elif level[g] < level[f]:
                g = low[g]
                continue
            else:
                slot = f * 12582917 + g * 4256249
                slot = 3 * ((slot ^ (slot >> 17)) & mask)
                if cache[slot] != f or cache[slot + 1] != g:
                    base = 4 * depth
                    frames[base], frames[base + 1], frames[base + 2] = f, g, 0
                    depth += 1
                    f, g = high[f], high[g] if level[f] == level[g] else g
                    continue
                result = cache[slot + 2]
            while depth:
                base = 4 * (depth - 1)
                f, g = frames[base], frames[base + 1]
                if frames[base + 2] == 0 and level[f] == level[g]:
                    # Its sets with the element must hold none of g without it, either.
                    frames[base + 2] = 1
                    f, g = result, low[g]
                    break
                if frames[base + 2] < 2:
                    frames[base + 2], frames[base + 3] = 2, result
                    f, g = low[f], low[g] if level[f] == level[g] else g
                    break
                depth -= 1
                result = self.node_of(level[f], result, frames[base + 3])
                if result == OUT_OF_NODES:
                    return OUT_OF_NODES
                slot = f * 12582917 + g * 4256249
                slot = 3 * ((slot ^ (slot >> 17)) & mask)
                cache[slot], cache[slot + 1], cache[slot + 2] = f, g, result
            else:
                return int(result)


def compact(
    root: int,
    count: int,
    set_level: Integers,
    set_low: Integers,
    set_high: Integers,
    number: Integers,
) -> int:
    """Keep only the constants and the nodes below a root, in place; return how many they are.

    number: (count,) zeros, scratch; out, the new number of each node kept.
    """
    number[root] = 1
    for node in range(count - 1, 1, -1):
        if number[node]:
            number[set_low[node]] = 1
            number[set_high[node]] = 1
    number[0] = 0
    number[1] = 1
    kept = 2
    for node in range(2, count):
        if number[node]:
            number[node] = kept
            set_level[kept] = set_level[node]
            set_low[kept] = number[set_low[node]]
            set_high[kept] = number[set_high[node]]
            kept += 1
    return kept


def totals(
    set_level: Integers, set_low: Integers, set_high: Integers, value: Floats, total: Floats
) -> None:
    """Give each family the sum over its sets of the product of their elements' values.

    value: (levels,); total: (n_nodes,) out.
    """
    total[0] = 0.0
    total[1] = 1.0
    for node in range(2, len(set_level)):
        total[node] = total[set_low[node]] + value[set_level[node]] * total[set_high[node]]


def greatest(
    set_level: Integers, set_low: Integers, set_high: Integers, value: Floats, most: Floats
) -> None:
    """Give each family the greatest product of the values of one set's elements, as `totals`."""
    most[0] = 0.0
    most[1] = 1.0
    for node in range(2, len(set_level)):
        most[node] = max(most[set_low[node]], value[set_level[node]] * most[set_high[node]])


def lightest(
    set_level: Integers,
    set_low: Integers,
    set_high: Integers,
    weight: Integers,
    none: int,
    least: Integers,
) -> None:
    """Give each family the least sum of the weights of one set's elements, at most `none`.

    weight: (levels,); none: of a family without sets; least: (n_nodes,) out.
    """
    least[0] = none
    least[1] = 0
    for node in range(2, len(set_level)):
        above = least[set_high[node]] + weight[set_level[node]]
        least[node] = min(above, least[set_low[node]])
