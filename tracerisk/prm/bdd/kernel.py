"""The loops of decision diagrams, on flat sequences, as Python.

`tracerisk/prm/compiled/diagrams.c` has the same functions, which run where they were compiled
(`tracerisk.prm.bdd.speed`); these run elsewhere, on lists, and say what each does.
Integer hashes stay below 2^63, and the stack is a sequence, so that both do the same.

An edge is twice a node's number, plus one for the complement; node 0 is the constant that always
happens (edge 0), edge 1 never.
A node's high edge is never a complement, so that a function and its complement share all nodes.
Nodes stand after those below them.
Canonical form: Bryant 1986; complement edges: Brace, Rudell, Bryant, "Efficient implementation of
a BDD package", DAC 1990.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    Integers = Any
    """A list of integers, or an array of them."""
    Floats = Any
    """A list of floats, or an array of them."""

OUT_OF_NODES = -1


def build(
    levels: int,
    first: int,
    offsets: Integers,
    literals: Integers,
    edges: Integers,
    nodes: Integers,
    table: Integers,
    cache: Integers,
    frames: Integers,
    used: Integers,
) -> int:
    """Build the diagrams of a sequence of ANDs; return the last one's edge, or OUT_OF_NODES.

    levels: number of variables; variable i has level i, 0 on top.
    first: the number of the first gate here; `nodes`, `table`, `cache`, `edges` and `used` go on
        from those of the gates before it.
    offsets: (n_gates + 1,) where each gate's arguments start in `literals`; a literal is
        2 (variable) or 2 (levels + gate), plus one for the complement.
    edges: out, the edge of each gate by number.
    nodes: (4 budget) out, the nodes: level, low edge, high edge and nothing of each.
    table: (power of two, over budget) zeros, the hash table of the nodes.
    cache: (3 times a power of two) zeros, the results of conjunctions: f, g, result.
    frames: (6 (levels + 2)) the stack.
    used: (2) in and out, how many nodes were made (0: none yet); how many literals are done.
    """
    budget = len(nodes) // 4
    table_mask = len(table) - 1
    cache_mask = len(cache) // 3 - 1
    nodes[0] = levels
    nodes[1] = 0
    nodes[2] = 0
    count = max(1, used[0])
    for gate in range(len(offsets) - 1):
        joined = 0
        for place in range(offsets[gate], offsets[gate + 1]):
            used[1] = place
            literal = literals[place]
            item = literal >> 1
            # One call of conjunction: (f, g), by a stack of frames.
            f = joined
            depth = 0
            single = item < levels
            if single:
                # A variable's own node: handled as the node (item, low=1, high=0) to be found.
                g = 0
            else:
                g = edges[item - levels] ^ (literal & 1)
            calling = True
            result = 0
            make_level = 0
            make_low = 0
            make_high = 0
            making = single
            while True:
                if calling and not making:
                    if f == g or g == 0:
                        result = f
                    elif f == 0:
                        result = g
                    elif f == 1 or g == 1 or (f ^ g) == 1:
                        result = 1
                    else:
                        if f > g:
                            f, g = g, f
                        slot = f * 12582917 + g * 4256249
                        slot = 3 * ((slot ^ (slot >> 17)) & cache_mask)
                        if cache[slot] == f and cache[slot + 1] == g:
                            result = cache[slot + 2]
                        else:
                            node_f = (f >> 1) << 2
                            node_g = (g >> 1) << 2
                            level_f = nodes[node_f]
                            level_g = nodes[node_g]
                            top = min(level_f, level_g)
                            if level_f == top:
                                sign = f & 1
                                f_high = nodes[node_f + 2] ^ sign
                                f_low = nodes[node_f + 1] ^ sign
                            else:
                                f_high = f
                                f_low = f
                            if level_g == top:
                                sign = g & 1
                                g_high = nodes[node_g + 2] ^ sign
                                g_low = nodes[node_g + 1] ^ sign
                            else:
                                g_high = g
                                g_low = g
                            base = 6 * depth
                            frames[base] = f
                            frames[base + 1] = g
                            frames[base + 2] = top
                            frames[base + 3] = f_low
                            frames[base + 4] = g_low
                            frames[base + 5] = -1
                            depth += 1
                            f = f_high
                            g = g_high
                            continue
                    calling = False
                if making:
                    sign = make_high & 1
                    if single:
                        make_level = item
                        make_high = 0
                        make_low = 1
                        sign = 0
                    make_high ^= sign
                    make_low ^= sign
                    slot = make_level * 741457 + make_low * 12582917 + make_high * 4256249
                    slot = (slot ^ (slot >> 17)) & table_mask
                    node = table[slot]
                    while node != 0 and (
                        nodes[4 * node + 1] != make_low
                        or nodes[4 * node + 2] != make_high
                        or nodes[4 * node] != make_level
                    ):
                        slot = (slot + 1) & table_mask
                        node = table[slot]
                    if node == 0:
                        if count >= budget:
                            used[0] = count
                            return -1
                        node = count
                        count += 1
                        table[slot] = node
                        nodes[4 * node] = make_level
                        nodes[4 * node + 1] = make_low
                        nodes[4 * node + 2] = make_high
                    result = 2 * node + sign
                    making = False
                    if single:
                        single = False
                        g = result ^ (literal & 1)
                        calling = True
                        continue
                    base = 6 * depth
                    f = frames[base]
                    g = frames[base + 1]
                    slot = f * 12582917 + g * 4256249
                    slot = 3 * ((slot ^ (slot >> 17)) & cache_mask)
                    cache[slot] = f
                    cache[slot + 1] = g
                    cache[slot + 2] = result
                if depth == 0:
                    break
                base = 6 * (depth - 1)
                if frames[base + 5] < 0:
                    frames[base + 5] = result
                    f = frames[base + 3]
                    g = frames[base + 4]
                    calling = True
                    continue
                depth -= 1
                make_high = frames[base + 5]
                make_low = result
                if make_high == make_low:
                    result = make_high
                    f = frames[base]
                    g = frames[base + 1]
                    slot = f * 12582917 + g * 4256249
                    slot = 3 * ((slot ^ (slot >> 17)) & cache_mask)
                    cache[slot] = f
                    cache[slot + 1] = g
                    cache[slot + 2] = result
                else:
                    make_level = frames[base + 2]
                    making = True
            joined = result
            if joined == 1:
                break
        edges[first + gate] = joined
    used[0] = count
    used[1] = len(literals)
    return int(edges[first + len(offsets) - 2])


def extract(
    root: int,
    count: int,
    nodes: Integers,
    number: Integers,
    level: Integers,
    low: Integers,
    high: Integers,
) -> int:
    """Copy the nodes below an edge; return their count, the constant's included.

    nodes: as `build` leaves them; number: (count,) zeros, scratch.
    level, low, high: (count,) out.
    """
    number[root >> 1] = 1
    for node in range(count - 1, 0, -1):
        if number[node]:
            number[nodes[4 * node + 1] >> 1] = 1
            number[nodes[4 * node + 2] >> 1] = 1
    number[0] = 0
    level[0] = nodes[0]
    low[0] = 0
    high[0] = 0
    kept = 1
    for node in range(1, count):
        if number[node]:
            number[node] = kept
            level[kept] = nodes[4 * node]
            below = nodes[4 * node + 1]
            low[kept] = 2 * number[below >> 1] + (below & 1)
            high[kept] = 2 * number[nodes[4 * node + 2] >> 1]
            kept += 1
    return kept
