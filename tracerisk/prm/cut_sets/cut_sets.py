"""Minimal cut sets and prime implicants of a fault tree: counted, summed, listed by probability."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.bdd.diagram import DEFAULT_LIMITS, Limits
from tracerisk.prm.bdd.logic import FALSE, FIRST_EVENT, TRUE, LogicGraph
from tracerisk.prm.bdd.modules import Module
from tracerisk.prm.bdd.shared_tree import SharedTree
from tracerisk.prm.cut_sets.family import (
    EMPTY_SET,
    NO_SET,
    Family,
    of_conjunction,
    of_diagram,
    of_disjunction,
    phases,
)
from tracerisk.prm.cut_sets.primes import primes_of_diagram

if TYPE_CHECKING:
    from tracerisk.prm.fault_tree import FaultTree

DEFAULT_BUDGET = 20_000_000
"""The most nodes of the family of one module; a node takes 12 bytes, and 40 while it is made."""


@dataclass(frozen=True, slots=True)
class CutSet:
    """Events that together make the top happen, none of them needless.

    `absent` are events that must not happen: a prime implicant of a tree that is not coherent.
    `probability` is the product of its events', `None` where no values were given.
    """

    events: tuple[str, ...]
    absent: tuple[str, ...] = ()
    probability: float | None = None

    @property
    def order(self) -> int:
        """The number of events, those that must not happen included."""
        return len(self.events) + len(self.absent)


@dataclass(frozen=True, slots=True)
class CutSets:
    """The minimal cut sets of a tree, held as families of sets of its modules.

    `max_order` is the order above which sets were left out, `None` for none.
    """

    max_order: int | None
    _graph: LogicGraph
    _families: Mapping[int, Family]

    def count(self) -> int:
        """Return how many there are, exactly."""
        return sum(self.count_by_order().values())

    def count_by_order(self) -> dict[int, int]:
        """Return how many there are of each order, exactly."""
        of_literal: dict[int, list[int]] = {}
        for literal, family in self._families.items():
            for element in family.literals:
                of_literal.setdefault(element, [0, 1])
            counts = family.counts(of_literal)
            of_literal[literal] = counts if self.max_order is None else counts[: self.max_order + 1]
        counts = of_literal.get(self._graph.top, _constant(self._graph.top))
        return {order: count for order, count in enumerate(counts) if count}

    def rare_event_sum(self, values: Mapping[str, float]) -> float:
        """Return the sum of the probabilities of all cut sets, without listing them.

        For a coherent tree an upper bound of the top's probability, and near to it where all
        are rare; above one where they are not.
        Raises ModelError for an event without a value.
        """
        found = self._literal_values(values)
        for literal, family in self._families.items():
            found[literal] = float(family.totals(found)[family.root])
        return found[self._graph.top]

    def most_probable(
        self, values: Mapping[str, float] | None = None, *, cut_off: float = 0.0
    ) -> Iterator[CutSet]:
        """Yield the cut sets, the most probable first, down to the probability `cut_off`.

        Without values those of the lowest order come first, and `cut_off` is not used.
        Equally probable ones come in an order that does not change from run to run.
        Raises ModelError for an event without a value.
        """
        if values is None:
            # Equal halves: a set of fewer events is the more probable one.
            weight = self._literal_values(dict.fromkeys(self._graph.events, 0.5))
            return (CutSet(each.events, each.absent) for each in self._in_order(weight, 0.0))
        return self._in_order(self._literal_values(values), cut_off)

    def _in_order(self, weight: dict[int, float], cut_off: float) -> Iterator[CutSet]:
        """Search best first: a part of a set, with the families that are left to choose from."""
        bounds: dict[int, Any] = {}
        for literal, family in self._families.items():
            bounds[literal] = family.greatest(weight)
            weight[literal] = float(bounds[literal][family.root])
        top = self._graph.top
        if top == FALSE:
            return
        number = itertools.count()
        # Each entry: bound, tie break, order, product of the chosen, literals, families to do.
        start = ((top, self._families[top].root), None) if top in self._families else None
        chosen: Any = (top, None) if start is None and abs(top) != TRUE else None
        product = weight[top] if chosen is not None else 1.0
        waiting: list[Any] = [(-weight[top], next(number), product, chosen, start)]
        while waiting:
            bound, _, product, chosen, pending = heapq.heappop(waiting)
            if -bound < cut_off:
                return
            if pending is None:
                found = self._cut_set(chosen, product)
                if self.max_order is None or found.order <= self.max_order:
                    yield found
                continue
            (literal, node), rest = pending
            family = self._families[literal]
            here = float(bounds[literal][node])
            others = -bound / here if here else 0.0
            # Down the low edges of one family all at once: each high edge is a choice.
            while node > EMPTY_SET:
                element = family.literals[family.level[node]]
                above = int(family.high[node])
                best = weight[element] * float(bounds[literal][above])
                left = ((literal, above), rest) if above != EMPTY_SET else rest
                if element in self._families:
                    entry = (product, chosen, ((element, self._families[element].root), left))
                else:
                    entry = (product * weight[element], (element, chosen), left)
                if not math.isinf(others) and others * best >= cut_off:
                    heapq.heappush(waiting, (-others * best, next(number), *entry))
                node = int(family.low[node])
            if node == EMPTY_SET:
                heapq.heappush(waiting, (-others, next(number), product, chosen, rest))

    def _cut_set(self, chosen: Any, product: float) -> CutSet:
        present: list[int] = []
        absent: list[int] = []
        while chosen is not None:
            literal, chosen = chosen
            (present if literal > 0 else absent).append(abs(literal))
        return CutSet(
            tuple(self._graph.event(node) for node in sorted(present)),
            tuple(self._graph.event(node) for node in sorted(absent)),
            product,
        )

    def _literal_values(self, values: Mapping[str, float]) -> dict[int, float]:
        found = {TRUE: 1.0, FALSE: 0.0}
        for node, event in enumerate(self._graph.events, FIRST_EVENT):
            if event not in values:
                raise ModelError(f"event '{event}' has no value; {one_of(values, event)}")
            if not 0.0 <= values[event] <= 1.0:
                raise ModelError(
                    f"event '{event}': probability {values[event]!r} is outside [0, 1]; "
                    "give a number within"
                )
            found[node], found[-node] = values[event], 1.0 - values[event]
        return found


def minimal_cut_sets(
    tree: FaultTree,
    *,
    max_order: int | None = None,
    budget: int = DEFAULT_BUDGET,
    limits: Limits = DEFAULT_LIMITS,
) -> CutSets:
    """Return the minimal cut sets: events that make the top happen when nothing else does.

    Of a coherent tree these are its prime implicants; of another, `prime_implicants` also tells
    which events must not happen.
    A module's are found on its decision diagram; those of the whole are never written out, so
    that a hundred million of them take little memory.
    `max_order` leaves out sets of more events.
    Raises TooLargeError when a module needs more than `budget` nodes, or as
    `FaultTree.probability` does.
    """
    solved = _solved(tree, max_order, limits)
    graph = solved.graph
    # The literal of each node that is false while nothing has happened.
    calm = list(range(len(graph.arguments)))
    families: dict[int, Family] = {}
    least = dict.fromkeys(range(FIRST_EVENT, graph.first_gate), 1)
    for module in solved.modules:
        root = module.root
        if module.is_simple:
            arguments = graph.arguments[root]
            if all(calm[abs(argument)] != argument for argument in arguments):
                calm[root] = -root
                family = of_disjunction([-argument for argument in arguments])
            else:
                family = of_conjunction([a for a in arguments if calm[abs(a)] == a])
        else:
            diagram = solved.diagrams[root]
            literals = tuple(calm[node] for node in diagram.order)
            if diagram.happens_at([literal < 0 for literal in literals]):
                calm[root] = -root
            sign = 1 if calm[root] > 0 else -1
            family = of_diagram(diagram, sign, literals, least, max_order, budget)
        families[calm[root]] = family
        least[calm[root]] = _least_order(family, least, max_order)
    if abs(graph.top) != TRUE and calm[abs(graph.top)] != graph.top:
        # The top happens while nothing has: the empty set, and no other is minimal.
        return CutSets(max_order, replace(graph, top=TRUE), {})
    return CutSets(max_order, graph, _below(graph.top, families))


def prime_implicants(
    tree: FaultTree,
    *,
    max_order: int | None = None,
    budget: int = DEFAULT_BUDGET,
    limits: Limits = DEFAULT_LIMITS,
) -> CutSets:
    """Return the prime implicants: what must happen, and what must not, for the top to happen.

    Of a coherent tree these are the minimal cut sets.
    Raises as `minimal_cut_sets` does.
    """
    solved = _solved(tree, max_order, limits)
    graph = solved.graph
    needed = {graph.top}
    wanted: list[tuple[int, Module, dict[int, int] | None]] = []
    for module in reversed(solved.modules):
        phase = phases(graph, module)
        for literal in (module.root, -module.root):
            if literal not in needed:
                continue
            wanted.append((literal, module, phase))
            for node in module.inputs:
                if phase is None:
                    needed |= {node, -node}
                else:
                    needed.add(node * phase[node] * _sign(literal))
    families: dict[int, Family] = {}
    least = {n * s: 1 for n in range(FIRST_EVENT, graph.first_gate) for s in (1, -1)}
    for literal, module, phase in reversed(wanted):
        sign = _sign(literal)
        if module.is_simple:
            arguments = graph.arguments[module.root]
            if literal > 0:
                family = of_conjunction(arguments)
            else:
                family = of_disjunction([-argument for argument in arguments])
        elif phase is not None:
            diagram = solved.diagrams[module.root]
            literals = tuple(node * phase[node] * sign for node in diagram.order)
            family = of_diagram(diagram, sign, literals, least, max_order, budget)
        else:
            family = primes_of_diagram(solved.diagrams[module.root], sign, budget)
        families[literal] = family
        least[literal] = _least_order(family, least, max_order)
    return CutSets(max_order, graph, families)


def _solved(tree: FaultTree, max_order: int | None, limits: Limits) -> SharedTree:
    if max_order is not None and max_order < 1:
        raise ModelError(f"max_order is {max_order}; give at least 1")
    return SharedTree(tree, limits)


def _sign(literal: int) -> int:
    return 1 if literal > 0 else -1


def _below(top: int, families: dict[int, Family]) -> dict[int, Family]:
    """Return the families that the top's sets are made of, each after those it names."""
    wanted = {top}
    for literal in reversed(families):
        if literal in wanted:
            wanted.update(families[literal].literals)
    return {literal: family for literal, family in families.items() if literal in wanted}


def _least_order(family: Family, least: Mapping[int, int], max_order: int | None) -> int:
    """Return the order of a family's smallest set; above `max_order` where it has none."""
    none = (max_order or 0) + 1
    orders = [none, 0]
    for node in range(2, family.size):
        element = family.literals[family.level[node]]
        above = orders[family.high[node]] + least[element]
        below = orders[family.low[node]] if family.low[node] != NO_SET else above
        orders.append(min(above, below))
    return orders[family.root]


def _constant(top: int) -> list[int]:
    if top == TRUE:
        return [1]
    return [] if top == FALSE else [0, 1]
