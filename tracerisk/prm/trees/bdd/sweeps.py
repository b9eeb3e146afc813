"""What is computed on a finished diagram, on flat arrays: probabilities, slopes, differences.

The nodes and edges are those of `kernel`; as there, `compiled/diagrams.c` has the same functions.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.trees.bdd.kernel import Floats, Integers

EXACT_ENOUGH = 16.0
"""A subtraction may lose this factor of the relative precision, not more."""


def sweep(
    level: Integers,
    low: Integers,
    high: Integers,
    p: Floats,
    q: Floats,
    happens: Floats,
    fails: Floats,
) -> None:
    """Give each node the probability of its function, `happens`, and of the complement, `fails`.

    p, q: (levels,) the probabilities of the variables.
    happens, fails: (n_nodes,) out.
    """
    happens[0] = 1.0
    fails[0] = 0.0
    for node in range(1, len(level)):
        p_here = p[level[node]]
        q_here = q[level[node]]
        below = low[node] >> 1
        above = high[node] >> 1
        if low[node] & 1:
            happens[node] = p_here * happens[above] + q_here * fails[below]
            fails[node] = p_here * fails[above] + q_here * happens[below]
        else:
            happens[node] = p_here * happens[above] + q_here * happens[below]
            fails[node] = p_here * fails[above] + q_here * fails[below]


def edge_gains(
    level: Integers,
    low: Integers,
    high: Integers,
    p: Floats,
    q: Floats,
    happens: Floats,
    fails: Floats,
    wanted: Integers,
    gains: Floats,
    memo_f: Integers,
    memo_g: Integers,
    memo_gain: Floats,
    frames: Integers,
    partial: Floats,
) -> int:
    """Give each node the probability of its high edge less that of its low edge.

    Where a subtraction would lose more than EXACT_ENOUGH, the difference is taken below, by pairs
    of edges: S(f, g) = p S(f1, g1) + q S(f0, g0).
    Of a coherent function all terms of a node have one sign, so that nothing cancels.
    Returns how many pairs were met; when the memo is full, the rest of the differences are
    subtracted as they stand and -1 is returned.

    wanted: (levels,) whether the nodes of a level are wanted; gains: (n_nodes,) out.
    memo_f: (power of two) zeros, memo_g and memo_gain alike: the pairs known.
    frames: (5 (levels + 2)) and partial: (levels + 2) the stack.
    """
    mask = len(memo_f) - 1
    most = len(memo_f) - len(memo_f) // 4
    pairs = 0
    full = False
    for start in range(1, len(level)):
        if not wanted[level[start]]:
            continue
        f = high[start]
        g = low[start]
        depth = 0
        result = 0.0
        while True:
            # A call: S(f, g).
            is_found = True
            if f == g:
                result = 0.0
            else:
                node_f = f >> 1
                node_g = g >> 1
                p_f, q_f = happens[node_f], fails[node_f]
                if f & 1:
                    p_f, q_f = q_f, p_f
                p_g, q_g = happens[node_g], fails[node_g]
                if g & 1:
                    p_g, q_g = q_g, p_g
                scale_p = max(p_f, p_g)
                scale_q = max(q_f, q_g)
                result, scale = p_f - p_g, scale_p
                if scale_p > scale_q:
                    result, scale = q_g - q_f, scale_q
                if abs(result) * EXACT_ENOUGH < scale and not full:
                    # Canonical pair: the greater node first, and regular.
                    sign = 0
                    if node_f < node_g:
                        f, g = g, f
                        sign = 1
                    if f & 1:
                        f ^= 1
                        g ^= 1
                        sign ^= 1
                    slot = f * 12582917 + g * 4256249
                    slot = (slot ^ (slot >> 17)) & mask
                    while memo_f[slot] != 0 and (memo_f[slot] != f or memo_g[slot] != g):
                        slot = (slot + 1) & mask
                    if memo_f[slot] != 0:
                        result = -memo_gain[slot] if sign else memo_gain[slot]
                    else:
                        is_found = False
                        base = 5 * depth
                        frames[base], frames[base + 1] = f, g
                        frames[base + 2], frames[base + 3] = sign, 0
                        node_f = f >> 1
                        node_g = g >> 1
                        top = min(level[node_f], level[node_g])
                        frames[base + 4] = top
                        if level[node_g] == top:
                            g = high[node_g] ^ (g & 1)
                        if level[node_f] == top:
                            f = high[node_f]
                        depth += 1
            if not is_found:
                continue
            # Returns, up to the next call.
            while depth > 0:
                base = 5 * (depth - 1)
                f = frames[base]
                g = frames[base + 1]
                top = frames[base + 4]
                if frames[base + 3] == 0:
                    frames[base + 3] = 1
                    partial[depth - 1] = p[top] * result
                    node_f = f >> 1
                    node_g = g >> 1
                    if level[node_g] == top:
                        g = low[node_g] ^ (g & 1)
                    if level[node_f] == top:
                        f = low[node_f]
                    break
                depth -= 1
                result = partial[depth] + q[top] * result
                if pairs < most:
                    slot = f * 12582917 + g * 4256249
                    slot = (slot ^ (slot >> 17)) & mask
                    while memo_f[slot] != 0:
                        slot = (slot + 1) & mask
                    memo_f[slot], memo_g[slot], memo_gain[slot] = f, g, result
                    pairs += 1
                else:
                    full = True
                if frames[base + 2]:
                    result = -result
            else:
                break
        gains[start] = result
    return -1 if full else pairs


def derivatives(
    root: int,
    level: Integers,
    low: Integers,
    high: Integers,
    p: Floats,
    q: Floats,
    gains: Floats,
    reach: Floats,
    out: Floats,
) -> None:
    """Give each variable the derivative of the root's probability by its own.

    reach: (n_nodes,) zeros, scratch: the signed probability that a path comes by.
    out: (levels,) zeros.
    """
    reach[root >> 1] = -1.0 if root & 1 else 1.0
    for node in range(len(level) - 1, 0, -1):
        weight = reach[node]
        here = level[node]
        out[here] += weight * gains[node]
        reach[high[node] >> 1] += weight * p[here]
        if low[node] & 1:
            reach[low[node] >> 1] -= weight * q[here]
        else:
            reach[low[node] >> 1] += weight * q[here]


def differences(
    level: Integers,
    low: Integers,
    high: Integers,
    p: Floats,
    q: Floats,
    drop: Floats,
    gains: Floats,
    out: Floats,
) -> None:
    """Give each node its probability under one assignment less that under another.

    p, q: (levels,) of the one assignment; drop: (levels,) its p less the other's; gains: of the
    other assignment, see `edge_gains`; out: (n_nodes,).
    """
    out[0] = 0.0
    for node in range(1, len(level)):
        here = level[node]
        below = out[low[node] >> 1]
        if low[node] & 1:
            below = -below
        out[node] = p[here] * out[high[node] >> 1] + q[here] * below + drop[here] * gains[node]
