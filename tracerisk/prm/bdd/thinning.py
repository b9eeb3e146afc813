"""Loops on a store of diagram nodes that holds approximations: thin out, and collect.

The nodes and edges are those of `kernel`; as there, `compiled/diagrams.c` has the same functions.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.bdd.kernel import Floats, Integers


def thinned(
    edge: int,
    most: int,
    nodes: Integers,
    table: Integers,
    p: Floats,
    q: Floats,
    happens: Floats,
    fails: Floats,
    reach: Floats,
    under: Integers,
    used: Integers,
) -> int:
    """Return a function that implies that of an edge, of about `most` nodes; -1 if out of nodes.

    Where paths from the edge that come by an edge below it are worth less than a bound, that one
    becomes the constant that never happens; the bound grows until few enough are left.
    So what is lost is at most the sum of those worths.

    nodes, table, used: as in `kernel.build`; p, q: (levels,); happens, fails: (n_nodes,) and
    reach, under: (2 n_nodes,) scratch.
    """
    root = edge >> 1
    count = used[0]
    budget = len(nodes) // 4
    table_mask = len(table) - 1
    happens[0] = 1.0
    fails[0] = 0.0
    for node in range(1, root + 1):
        here = nodes[4 * node]
        low = nodes[4 * node + 1]
        below = low >> 1
        above = nodes[4 * node + 2] >> 1
        if low & 1:
            happens[node] = p[here] * happens[above] + q[here] * fails[below]
            fails[node] = p[here] * fails[above] + q[here] * happens[below]
        else:
            happens[node] = p[here] * happens[above] + q[here] * happens[below]
            fails[node] = p[here] * fails[above] + q[here] * fails[below]
    whole = fails[root] if edge & 1 else happens[root]
    least = 0.0
    while True:
        kept = 0
        for half in range(2 * root + 2):
            reach[half] = 0.0
        reach[edge] = 1.0
        for node in range(root, 0, -1):
            here = nodes[4 * node]
            low = nodes[4 * node + 1]
            high = nodes[4 * node + 2]
            for sign in range(2):
                weight = reach[2 * node + sign]
                if weight > 0.0:
                    worth = weight * (fails[node] if sign else happens[node])
                    if worth <= least:
                        reach[2 * node + sign] = -1.0
                    else:
                        kept += 1
                        if reach[high ^ sign] >= 0.0:
                            reach[high ^ sign] += weight * p[here]
                        if reach[low ^ sign] >= 0.0:
                            reach[low ^ sign] += weight * q[here]
        if kept <= most:
            break
        least = 4.0 * least if least > 0.0 else whole * 1e-12
    if least == 0.0:
        return edge
    under[0] = 0
    under[1] = 1
    for node in range(1, root + 1):
        for sign in range(2):
            half = 2 * node + sign
            under[half] = 1
            if reach[half] > 0.0:
                made_low = under[nodes[4 * node + 1] ^ sign]
                made_high = under[nodes[4 * node + 2] ^ sign]
                if made_low == made_high:
                    under[half] = made_low
                    continue
                flip = made_high & 1
                made_low ^= flip
                made_high ^= flip
                here = nodes[4 * node]
                slot = here * 741457 + made_low * 12582917 + made_high * 4256249
                slot = (slot ^ (slot >> 17)) & table_mask
                found = table[slot]
                while found != 0 and (
                    nodes[4 * found + 1] != made_low
                    or nodes[4 * found + 2] != made_high
                    or nodes[4 * found] != here
                ):
                    slot = (slot + 1) & table_mask
                    found = table[slot]
                if found == 0:
                    if count >= budget:
                        return -1
                    found = count
                    count += 1
                    table[slot] = found
                    nodes[4 * found] = here
                    nodes[4 * found + 1] = made_low
                    nodes[4 * found + 2] = made_high
                under[half] = 2 * found + flip
    used[0] = count
    return int(under[edge])


def collect(
    edges: Integers,
    nodes: Integers,
    table: Integers,
    cache: Integers,
    number: Integers,
    used: Integers,
) -> None:
    """Keep only the nodes below the edges, and renumber those; -1 among the edges is none.

    number: (n_nodes,) scratch; the others as in `kernel.build`, the cache emptied.
    """
    count = used[0]
    table_mask = len(table) - 1
    for slot in range(len(cache)):
        cache[slot] = 0
    for node in range(count):
        number[node] = 0
    for place in range(len(edges)):
        if edges[place] >= 0:
            number[edges[place] >> 1] = 1
    for node in range(count - 1, 0, -1):
        if number[node]:
            number[nodes[4 * node + 1] >> 1] = 1
            number[nodes[4 * node + 2] >> 1] = 1
    for slot in range(len(table)):
        table[slot] = 0
    number[0] = 0
    kept = 1
    for node in range(1, count):
        if number[node]:
            number[node] = kept
            here = nodes[4 * node]
            low = 2 * number[nodes[4 * node + 1] >> 1] + (nodes[4 * node + 1] & 1)
            high = 2 * number[nodes[4 * node + 2] >> 1]
            nodes[4 * kept] = here
            nodes[4 * kept + 1] = low
            nodes[4 * kept + 2] = high
            slot = here * 741457 + low * 12582917 + high * 4256249
            slot = (slot ^ (slot >> 17)) & table_mask
            while table[slot] != 0:
                slot = (slot + 1) & table_mask
            table[slot] = kept
            kept += 1
    for place in range(len(edges)):
        if edges[place] >= 0:
            edges[place] = 2 * number[edges[place] >> 1] + (edges[place] & 1)
    used[0] = kept
