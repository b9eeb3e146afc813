"""Minimal cut sets and prime implicants of a fault tree: counted, summed, listed by probability."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.bdd.logic import FALSE, FIRST_EVENT, TRUE, LogicGraph
from tracerisk.prm.cut_sets.family import (
    EMPTY_SET,
    Family,
)

if TYPE_CHECKING:
    pass


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


def _constant(top: int) -> list[int]:
    if top == TRUE:
        return [1]
    return [] if top == FALSE else [0, 1]
