"""The loop on a store of diagram nodes that holds approximations: thin out.

The nodes and edges are those of `kernel`; as there, `compiled/diagrams.c` has the same function.
"""

from __future__ import annotations

from tracerisk.prm.trees.bdd.kernel import OUT_OF_NODES, Store

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.trees.bdd.kernel import Floats, Integers


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
    """Return a function of about `most` nodes that implies the function of `edge`.

    OUT_OF_NODES where there is no room for it.

    An edge below `edge` whose paths carry less probability than a bound is replaced by the constant
    that never happens; the bound grows until few enough are left.
    So what is lost is at most the sum of those worths.

    nodes, table, used: as in `kernel.build`; p, q: (levels,); happens, fails: (n_nodes,) and
    reach, under: (2 n_nodes,) scratch.
    """
    root = edge >> 1
    store = Store((), nodes, table, (), (), used)
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
                number = store.edge_of(nodes[4 * node], made_low, made_high)
                if number == OUT_OF_NODES:
                    return OUT_OF_NODES
                under[half] = number
    used[0] = store.count
    return int(under[edge])
