"""The loops of decision diagrams, on flat sequences, as Python.

`tracerisk/prm/compiled/diagrams.c` has the same functions, which run where they were compiled
(`tracerisk.prm.trees.bdd.speed`); these run elsewhere, on lists, and say what each does.
Integer hashes stay below 2^63, and the stack is a sequence, so that both do the same.

An edge is twice a node's number, plus one for the complement; node 0 is the constant that always
happens (edge 0), edge 1 never.
A node's high edge is never a complement, so that a function and its complement share all nodes.
Nodes stand after those below them.
Canonical form: Bryant 1986; complement edges: Brace, Rudell, Bryant, "Efficient implementation of
a BDD package", DAC 1990.

Only the first nodes of a store are in use, and so many slots of its table and its cache as belong
to them: little memory is touched for a diagram that stays small.
When those are full, what nothing needs any more is given up; where most is needed, the store
becomes twice as large, up to its budget.
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

_FIRST_SIZE = 4096
_LEAST_SLOTS = 16
_STEPS = 8
"""How many conjunctions may be expanded for each node of the budget, to bound the time."""


class Store:
    """The nodes of diagrams, the table by which they are found, and what is known of them.

    The sequences are those of `build`; `size` is how many nodes there is room for.
    """

    def __init__(
        self,
        edges: Integers,
        nodes: Integers,
        table: Integers,
        cache: Integers,
        frames: Integers,
        used: Integers,
    ) -> None:
        self.edges, self.nodes, self.table, self.cache = edges, nodes, table, cache
        self.frames, self.depth = frames, 0
        self.count, self.size = used[0], used[2]
        self.table_mask = _mask_of(self.size + self.size // 4)
        self.cache_mask = _mask_of(self.size)
        self.budget = len(nodes) // 4
        self.steps_left = _STEPS * self.budget

    def empty(self, levels: int) -> None:
        """Make an empty store of what was perhaps in use before."""
        for slot in range(self.table_mask + 1):
            self.table[slot] = 0
        for slot in range(3 * (self.cache_mask + 1)):
            self.cache[slot] = 0
        self.nodes[0], self.nodes[1], self.nodes[2] = levels, 0, 0
        self.count = 1

    def edge_of(self, level: int, low: int, high: int) -> int:
        """Return the edge of a level and two different edges, or OUT_OF_NODES."""
        nodes, table, mask = self.nodes, self.table, self.table_mask
        sign = high & 1
        low ^= sign
        high ^= sign
        slot = level * 741457 + low * 12582917 + high * 4256249
        slot = (slot ^ (slot >> 17)) & mask
        node = table[slot]
        while node:
            at = 4 * node
            if nodes[at + 1] == low and nodes[at + 2] == high and nodes[at] == level:
                return int(2 * node + sign)
            slot = (slot + 1) & mask
            node = table[slot]
        node = self.count
        if node >= self.size:
            return OUT_OF_NODES
        self.count += 1
        table[slot] = node
        at = 4 * node
        nodes[at], nodes[at + 1], nodes[at + 2] = level, low, high
        return int(2 * node + sign)

    def with_room(self, held: int) -> int:
        """Give up what nothing needs; return what an edge that is held becomes.

        OUT_OF_NODES where more than three quarters of the budget are needed; where the steps have
        no limit, only where all of it is.
        """
        live = self.marked(held)
        size = self.size
        if 2 * live > size:
            size = min(2 * size, self.budget)
        most = size - 1 if self.steps_left < 0 else 3 * size // 4
        if live > most:
            return OUT_OF_NODES
        return self.compacted(size, held)

    def marked(self, held: int) -> int:
        """Mark, in their fourth number, the nodes that are still needed; return their count."""
        nodes, frames = self.nodes, self.frames
        for at in range(3, 4 * self.count, 4):
            nodes[at] = 0
        nodes[(held >> 1 << 2) + 3] = 1
        for edge in self.edges:
            if edge >= 0:
                nodes[(edge >> 1 << 2) + 3] = 1
        for base in range(0, 6 * self.depth, 6):
            for edge in (frames[base], frames[base + 1], frames[base + 5]):
                if edge >= 0:
                    nodes[(edge >> 1 << 2) + 3] = 1
        live = 1
        for at in range(4 * self.count - 4, 0, -4):
            if nodes[at + 3]:
                nodes[(nodes[at + 1] >> 1 << 2) + 3] = 1
                nodes[(nodes[at + 2] >> 1 << 2) + 3] = 1
                live += 1
        return live

    def compacted(self, size: int, held: int) -> int:
        """Keep the marked nodes only, with room for `size`; return what `held` becomes."""
        nodes, table, edges, frames = self.nodes, self.table, self.edges, self.frames
        self.size = size
        self.table_mask = mask = _mask_of(size + size // 4)
        for slot in range(mask + 1):
            table[slot] = 0
        nodes[3] = 0
        kept = 1
        for at in range(4, 4 * self.count, 4):
            if nodes[at + 3]:
                level = nodes[at]
                low, high = self._renumbered(nodes[at + 1]), self._renumbered(nodes[at + 2])
                nodes[at + 3] = kept
                to = 4 * kept
                nodes[to], nodes[to + 1], nodes[to + 2] = level, low, high
                slot = level * 741457 + low * 12582917 + high * 4256249
                slot = (slot ^ (slot >> 17)) & mask
                while table[slot]:
                    slot = (slot + 1) & mask
                table[slot] = kept
                kept += 1
        for place, edge in enumerate(edges):
            if edge >= 0:
                edges[place] = self._renumbered(edge)
        for base in range(0, 6 * self.depth, 6):
            for place in (base, base + 1, base + 3, base + 4, base + 5):
                if frames[place] >= 0:
                    frames[place] = self._renumbered(frames[place])
        self._move_known(_mask_of(size))
        self.count = kept
        return self._renumbered(held)

    def _renumbered(self, edge: int) -> int:
        """Return what an edge becomes; its node's fourth number says the node's new number."""
        return int(2 * self.nodes[(edge >> 1 << 2) + 3] + (edge & 1))

    def _move_known(self, mask: int) -> None:
        """Move each known conjunction to its new slot; f is negative where it still has to."""
        nodes, cache = self.nodes, self.cache
        for place in range(0, 3 * (self.cache_mask + 1), 3):
            if not cache[place]:
                continue
            entry = cache[place], cache[place + 1], cache[place + 2]
            if all(edge < 2 or nodes[(edge >> 1 << 2) + 3] for edge in entry):
                f, g, result = map(self._renumbered, entry)
                cache[place], cache[place + 1], cache[place + 2] = -f, g, result
            else:
                cache[place] = cache[place + 1] = cache[place + 2] = 0
        for place in range(3 * (self.cache_mask + 1), 3 * (mask + 1)):
            cache[place] = 0
        for place in range(0, 3 * (self.cache_mask + 1), 3):
            f, g, result = cache[place], cache[place + 1], cache[place + 2]
            if f < 0:
                cache[place] = cache[place + 1] = cache[place + 2] = 0
            while f < 0:
                f = -f
                slot = f * 12582917 + g * 4256249
                to = 3 * ((slot ^ (slot >> 17)) & mask)
                before = cache[to], cache[to + 1], cache[to + 2]
                cache[to], cache[to + 1], cache[to + 2] = f, g, result
                f, g, result = before
        self.cache_mask = mask

    def conjunction(self, f: int, g: int) -> int:
        """Return the edge of "f and g", by a stack of frames, or OUT_OF_NODES.

        A frame is f, g, their top level, the low edges of both there, and the result of the high
        edges, -1 as long as there is none.
        """
        nodes, cache, frames = self.nodes, self.cache, self.frames
        while True:
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
                slot = 3 * ((slot ^ (slot >> 17)) & self.cache_mask)
                if cache[slot] == f and cache[slot + 1] == g:
                    result = cache[slot + 2]
                else:
                    if not self.steps_left:
                        return OUT_OF_NODES
                    self.steps_left -= 1
                    node_f, node_g = f >> 1 << 2, g >> 1 << 2
                    level = min(nodes[node_f], nodes[node_g])
                    f_low = f_high = f
                    g_low = g_high = g
                    if nodes[node_f] == level:
                        f_low, f_high = nodes[node_f + 1] ^ (f & 1), nodes[node_f + 2] ^ (f & 1)
                    if nodes[node_g] == level:
                        g_low, g_high = nodes[node_g + 1] ^ (g & 1), nodes[node_g + 2] ^ (g & 1)
                    base = 6 * self.depth
                    frames[base], frames[base + 1], frames[base + 2] = f, g, level
                    frames[base + 3], frames[base + 4], frames[base + 5] = f_low, g_low, -1
                    self.depth += 1
                    f, g = f_high, g_high
                    continue
            while self.depth:
                base = 6 * (self.depth - 1)
                if frames[base + 5] < 0:
                    frames[base + 5] = result
                    f, g = frames[base + 3], frames[base + 4]
                    break
                if frames[base + 5] != result:
                    if self.count >= self.size:
                        result = self.with_room(result)
                    if result != OUT_OF_NODES:
                        result = self.edge_of(frames[base + 2], result, frames[base + 5])
                    if result == OUT_OF_NODES:
                        return OUT_OF_NODES
                self.depth -= 1
                f, g = frames[base], frames[base + 1]
                slot = f * 12582917 + g * 4256249
                slot = 3 * ((slot ^ (slot >> 17)) & self.cache_mask)
                cache[slot], cache[slot + 1], cache[slot + 2] = f, g, result
            else:
                return int(result)


def _mask_of(least: int) -> int:
    """Return the mask of slots of a power of two, at least so many."""
    size = _LEAST_SLOTS
    while size < least:
        size *= 2
    return size - 1


def build(
    levels: int,
    first: int,
    offsets: Integers,
    literals: Integers,
    last: Integers,
    edges: Integers,
    nodes: Integers,
    table: Integers,
    cache: Integers,
    frames: Integers,
    used: Integers,
) -> int:
    """Build the conjunctions of gates, one after the other; return the last one's edge.

    OUT_OF_NODES when its nodes or steps are used up.

    levels: how many variables there are.
    first: the place among `edges` of the first gate's.
    offsets, literals: gate i is the AND of `literals[offsets[i]:offsets[i + 1]]`, each twice an
        item's number plus one for its complement; items below `levels` are variables, the others
        gates.
    last: (gates) the place among `literals` at which each gate is used last, after which its edge
        is given up. Empty: all edges are kept, and the steps have no limit.
    edges: of each gate, in and out; -1 is none.
    nodes: (4 budget) out, the nodes: level, low edge, high edge and scratch of each.
    table: (power of two, at least 5/4 budget) the hash table of the nodes.
    cache: (3 times a power of two, at least the budget) conjunctions: f, g, result.
    frames: (6 (levels + 2)) the stack.
    used: (3) in and out, how many nodes were made (0: none, and nothing is read of the store's
        sequences); how many literals are done; for how many nodes there is room (0: for few).
    """
    if not used[2]:
        used[2] = min(len(nodes) // 4, _FIRST_SIZE)
    store = Store(edges, nodes, table, cache, frames, used)
    if not len(last):
        store.steps_left = -1  # no limit
    if not used[0]:
        store.empty(levels)
    joined = 0
    place = 0
    for gate in range(len(offsets) - 1):
        joined = 0
        for place in range(offsets[gate], offsets[gate + 1]):
            item, sign = literals[place] >> 1, literals[place] & 1
            if store.count >= store.size:
                joined = store.with_room(joined)
                if joined == OUT_OF_NODES:
                    break
            if item < levels:
                g = store.edge_of(item, 1, 0)
            else:
                g = edges[item - levels]
                if len(last) and last[item - levels] == place:
                    edges[item - levels] = -1
            joined = store.conjunction(joined, g ^ sign)
            if joined == OUT_OF_NODES or joined == 1:
                break
        if joined == OUT_OF_NODES:
            break
        edges[first + gate] = joined
    used[0] = store.count
    used[1] = place if joined == OUT_OF_NODES else len(literals)
    used[2] = store.size
    return joined


def collect(
    edges: Integers, nodes: Integers, table: Integers, cache: Integers, used: Integers
) -> None:
    """Keep only the nodes below the edges, and renumber those; all as in `build`."""
    store = Store(edges, nodes, table, cache, (), used)
    store.marked(0)
    store.compacted(store.size, 0)
    used[0] = store.count


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
