"""Prime implicants of a module that is not monotone.

Coudert and Madre, "Implicit and incremental computation of primes and essential primes of Boolean
functions", DAC 1992: the primes of f without the variable x are those of f1 f0; with x, those of
f1 that are none of these; with its complement, those of f0 that are none of these.
"""

from __future__ import annotations

from tracerisk.errors import TooLargeError
from tracerisk.prm.other_models.cut_sets.family import EMPTY_SET, NO_SET, Family
from tracerisk.prm.trees.bdd.diagram import Diagram
from tracerisk.prm.trees.bdd.speed import plain_loops


def primes_of_diagram(diagram: Diagram, sign: int, budget: int) -> Family:
    """Return the prime implicants of a module's diagram, or of its complement (`sign` -1).

    Raises TooLargeError when more than a tenth of `budget` nodes are needed: these are kept in
    dictionaries.
    """
    primes = _Primes(diagram, max(1000, budget // 10))
    root = primes.of(diagram.root ^ int(sign < 0))
    # Level 2 i stands for the variable i, level 2 i + 1 for its complement.
    literals = tuple(literal for node in diagram.order for literal in (node, -node))
    return Family(root, literals, primes.set_level, primes.set_low, primes.set_high, plain_loops())


class _Primes:
    def __init__(self, diagram: Diagram, budget: int) -> None:
        self._budget = budget
        self._levels = len(diagram.order)
        self.level = [int(item) for item in diagram.level]
        self.low = [int(item) for item in diagram.low]
        self.high = [int(item) for item in diagram.high]
        self._nodes = {
            key: node
            for node, key in enumerate(zip(self.level, self.low, self.high, strict=True))
            if node
        }
        last = 2 * self._levels
        self.set_level = [last, last]
        self.set_low = [0, 0]
        self.set_high = [0, 0]
        self._sets: dict[tuple[int, int, int], int] = {}
        self._primes: dict[int, int] = {0: EMPTY_SET, 1: NO_SET}
        self._ands: dict[tuple[int, int], int] = {}
        self._less: dict[tuple[int, int], int] = {}

    def of(self, root: int) -> int:
        """Return the family of the prime implicants of an edge."""
        stack = [root]
        while stack:
            edge = stack[-1]
            if edge in self._primes:
                stack.pop()
                continue
            above, below = self._cofactors(edge, self.level[edge >> 1])
            both = self._and(above, below)
            missing = [number for number in (above, below, both) if number not in self._primes]
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            here = 2 * self.level[edge >> 1]
            common = self._primes[both]
            with_it = self._difference(self._primes[above], common)
            without = self._difference(self._primes[below], common)
            self._primes[edge] = self._set(here, self._set(here + 1, common, without), with_it)
        return self._primes[root]

    def _cofactors(self, edge: int, level: int) -> tuple[int, int]:
        node = edge >> 1
        if self.level[node] != level:
            return edge, edge
        return self.high[node] ^ (edge & 1), self.low[node] ^ (edge & 1)

    def _and(self, f: int, g: int) -> int:
        """Return the edge of the conjunction of two, by a stack of its own."""
        results: list[int] = []
        stack: list[tuple[int, int, int]] = [(f, g, 0)]
        while stack:
            f, g, step = stack.pop()
            if f > g:
                f, g = g, f
            if step == 0:
                if f == g or f == 0:
                    results.append(g)
                elif f == 1 or f ^ g == 1:
                    results.append(1)
                elif (f, g) in self._ands:
                    results.append(self._ands[f, g])
                else:
                    level = min(self.level[f >> 1], self.level[g >> 1])
                    f_above, f_below = self._cofactors(f, level)
                    g_above, g_below = self._cofactors(g, level)
                    stack += [(f, g, 1), (f_above, g_above, 0), (f_below, g_below, 0)]
                continue
            above, below = results.pop(), results.pop()
            level = min(self.level[f >> 1], self.level[g >> 1])
            node = self._ands[f, g] = self._node(level, below, above)
            results.append(node)
        return results[0]

    def _node(self, level: int, low: int, high: int) -> int:
        if low == high:
            return low
        sign = high & 1
        key = (level, low ^ sign, high ^ sign)
        node = self._nodes.get(key)
        if node is None:
            node = self._nodes[key] = len(self.level)
            self.level.append(level)
            self.low.append(low ^ sign)
            self.high.append(high ^ sign)
            self._check(node)
        return 2 * node + sign

    def _set(self, level: int, low: int, high: int) -> int:
        if high == NO_SET:
            return low
        key = (level, low, high)
        node = self._sets.get(key)
        if node is None:
            node = self._sets[key] = len(self.set_level)
            self.set_level.append(level)
            self.set_low.append(low)
            self.set_high.append(high)
            self._check(node)
        return node

    def _difference(self, a: int, b: int) -> int:
        """Return the family of the sets of `a` that are no sets of `b`."""
        results: list[int] = []
        stack: list[tuple[int, int, int]] = [(a, b, 0)]
        while stack:
            a, b, step = stack.pop()
            if step:
                low, high = results.pop(), results.pop()
                result = self._less[a, b] = self._set(self.set_level[a], low, high)
                results.append(result)
                continue
            while b > EMPTY_SET and self.set_level[b] < self.set_level[a]:
                b = self.set_low[b]
            if a in (b, NO_SET):
                results.append(NO_SET)
            elif b == NO_SET:
                results.append(a)
            elif (a, b) in self._less:
                results.append(self._less[a, b])
            elif a == EMPTY_SET:
                results.append(EMPTY_SET)
            else:
                alike = self.set_level[a] == self.set_level[b]
                b_low, b_high = (self.set_low[b], self.set_high[b]) if alike else (b, NO_SET)
                stack += [(a, b, 1), (self.set_low[a], b_low, 0), (self.set_high[a], b_high, 0)]
        return results[0]

    def _check(self, count: int) -> None:
        if count > self._budget:
            raise TooLargeError(
                f"the prime implicants of a module with {self._levels} inputs need more than "
                f"{self._budget} nodes; divide the tree, or give a larger budget"
            )
