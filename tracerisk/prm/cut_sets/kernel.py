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

    root, level, low, high: the decision diagram, see `tracerisk.prm.bdd.kernel`.
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
    budget = len(set_level)
    table_mask = len(table) - 1
    cache_mask = len(cache) // 3 - 1
    columns = most + 1
    levels = level[0]
    set_level[0] = levels
    set_level[1] = levels
    count = 2
    needed[root * columns + most] = 1
    for node in range(len(level) - 1, 0, -1):
        here = level[node]
        heavy = weight[here]
        for sign in range(2):
            for room in range(columns):
                if needed[(2 * node + sign) * columns + room]:
                    above = high[node] ^ sign
                    below = low[node] ^ sign
                    if not rising[here]:
                        above, below = below, above
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
            for room in range(columns):
                place = (2 * node + sign) * columns + room
                if not needed[place]:
                    continue
                above = high[node] ^ sign
                below = low[node] ^ sign
                if not rising[here]:
                    above, below = below, above
                rest = family[below * columns + room]
                f = 0
                if room >= heavy:
                    f = family[above * columns + room - heavy]
                # Without(f, g): the sets of f that hold no set of g.
                g = rest
                depth = 0
                result = 0
                calling = True
                making = False
                make_level = 0
                make_low = 0
                make_high = 0
                last = False
                while True:
                    if calling:
                        if f == 0 or g == 1 or f == g:
                            result = 0
                        elif g == 0 or f == 1:
                            result = f
                        elif set_level[g] < set_level[f]:
                            g = set_low[g]
                            continue
                        else:
                            slot = f * 12582917 + g * 4256249
                            slot = 3 * ((slot ^ (slot >> 17)) & cache_mask)
                            if cache[slot] == f and cache[slot + 1] == g:
                                result = cache[slot + 2]
                            else:
                                base = 4 * depth
                                frames[base] = f
                                frames[base + 1] = g
                                frames[base + 2] = 0
                                depth += 1
                                if set_level[f] == set_level[g]:
                                    g = set_high[g]
                                f = set_high[f]
                                continue
                        calling = False
                    if making:
                        result = make_low
                        if make_high != 0:
                            slot = make_level * 741457 + make_low * 12582917 + make_high * 4256249
                            slot = (slot ^ (slot >> 17)) & table_mask
                            found = table[slot]
                            while found != 0 and (
                                set_low[found] != make_low
                                or set_high[found] != make_high
                                or set_level[found] != make_level
                            ):
                                slot = (slot + 1) & table_mask
                                found = table[slot]
                            if found == 0:
                                if count >= budget:
                                    used[0] = count
                                    return -1
                                found = count
                                count += 1
                                table[slot] = found
                                set_level[found] = make_level
                                set_low[found] = make_low
                                set_high[found] = make_high
                            result = found
                        making = False
                        if last:
                            break
                        base = 4 * depth
                        slot = frames[base] * 12582917 + frames[base + 1] * 4256249
                        slot = 3 * ((slot ^ (slot >> 17)) & cache_mask)
                        cache[slot] = frames[base]
                        cache[slot + 1] = frames[base + 1]
                        cache[slot + 2] = result
                    if depth == 0:
                        # The element before what is left, beside the sets without it.
                        last = True
                        making = True
                        make_level = here
                        make_low = rest
                        make_high = result
                        continue
                    base = 4 * (depth - 1)
                    f = frames[base]
                    g = frames[base + 1]
                    if frames[base + 2] == 0 and set_level[f] == set_level[g]:
                        # Its sets with the element must hold none of g without it, either.
                        frames[base + 2] = 1
                        f = result
                        g = set_low[g]
                        calling = True
                    elif frames[base + 2] < 2:
                        frames[base + 2] = 2
                        frames[base + 3] = result
                        if set_level[f] == set_level[g]:
                            g = set_low[g]
                        f = set_low[f]
                        calling = True
                    else:
                        depth -= 1
                        making = True
                        make_level = set_level[f]
                        make_low = result
                        make_high = frames[base + 3]
                family[place] = result
    used[0] = count
    return int(family[root * columns + most])


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
