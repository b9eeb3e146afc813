"""Minimal cut sets and prime implicants of a fault tree: counted, summed, listed by probability."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.probability import pair_of
from tracerisk.prm.other_models.cut_sets.family import EMPTY_SET, Family
from tracerisk.prm.trees.bdd.logic import FALSE, FIRST_EVENT, TRUE, LogicGraph

_ROUNDING = 1e-9
"""More than the rounding of a product of a million factors; see `CutSets._in_order`."""


@dataclass(frozen=True, slots=True)
class CutSet:
    """Events that together make the top happen, none of them needless."""

    events: tuple[str, ...]
    """Names of the events that must happen."""
    absent: tuple[str, ...] = ()
    """Names of the events that must not happen, in a tree that is not coherent."""
    probability: float | None = None
    """Product of the probabilities of `events` and of the complements of `absent`; `None` where
    no values were given."""

    @property
    def order(self) -> int:
        """The number of events, those that must not happen included."""
        return len(self.events) + len(self.absent)


@dataclass(frozen=True, slots=True)
class CutSets:
    """The minimal cut sets of a tree, held as families of sets of its modules."""

    max_order: int | None
    """Order above which sets were left out; `None` for no limit."""
    _graph: LogicGraph = field(repr=False)
    """Logic graph of the tree, by whose literals the families are built."""
    _families: Mapping[int, Family] = field(repr=False)
    """Family of the minimal solutions of each module, by literal of its root."""
    _parameters: Mapping[str, str] = field(repr=False)
    """The parameter of each event."""

    def count(self) -> int:
        """Return how many there are, exactly."""
        return sum(self.count_by_order().values())

    def count_by_order(self) -> dict[int, int]:
        """Return how many there are of each order, exactly."""
        counts = self._by_order(dict.fromkeys(self._literals(), 1))
        return {order: int(count) for order, count in enumerate(counts) if count}

    def rare_event_sum(self, values: Mapping[str, float]) -> float:
        """Return the sum of the probabilities of all cut sets, without listing them.

        `values` gives each parameter the probability of one event.
        For a coherent tree an upper bound of the top's probability, and near to it where all
        are rare; above one where they are not.
        Raises ModelError for a parameter without a value.
        """
        literal_values = self._literal_values(values)
        if self.max_order is not None:
            return float(sum(self._by_order(literal_values)))
        for literal, family in self._families.items():
            literal_values[literal] = float(family.totals(literal_values)[family.root])
        return literal_values[self._graph.top]

    def most_probable(
        self, values: Mapping[str, float] | None = None, *, cut_off: float = 0.0
    ) -> Iterator[CutSet]:
        """Yield the cut sets, the most probable first, down to the probability `cut_off`.

        `values` gives each parameter the probability of one event; without it those of the
        lowest order come first, and `cut_off` is not used.
        Equally probable ones (to rounding) come in an order that is the same in every run.
        Raises ModelError for a parameter without a value, or a cut-off that is not a probability.
        """
        if values is None:
            # All of one weight: then the order decides.
            weight = {TRUE: 1.0, FALSE: 0.0} | dict.fromkeys(self._literals(), 1.0)
            return (
                CutSet(cut_set.events, cut_set.absent) for cut_set in self._in_order(weight, 0.0)
            )
        if not 0.0 <= cut_off <= 1.0:
            raise ModelError(f"cut_off is {cut_off!r}; give a probability, 0 to 1")
        return self._in_order(self._literal_values(values), cut_off)

    def _in_order(self, weight: dict[int, float], cut_off: float) -> Iterator[CutSet]:
        """Search best first: a part of a set, with the families that are left to choose from.

        Of equal probability, the smallest possible order comes first.
        """
        bounds: dict[int, Any] = {}
        orders: dict[int, Any] = {}
        lightest = dict.fromkeys(self._literals(), 1)
        most = self.max_order
        for literal, family in self._families.items():
            bounds[literal] = family.greatest(weight)
            weight[literal] = float(bounds[literal][family.root])
            orders[literal] = family.lightest(lightest, most)
            lightest[literal] = int(orders[literal][family.root])
        # A bound may be rounded down from the product that it stands for.
        reached = cut_off * (1.0 - _ROUNDING)

        def left_to_do(literal: int, node: int, rest: Any) -> Any:
            """Put a family before others: with the best product and the least order of all."""
            worth, order = (rest[3], rest[4]) if rest is not None else (1.0, 0)
            return (
                literal,
                node,
                rest,
                float(bounds[literal][node]) * worth,
                int(orders[literal][node]) + order,
            )

        number = itertools.count()
        waiting: list[Any] = []

        def wait(product: float, order: int, chosen: Any, pending: Any) -> None:
            bound, least = product, order
            if pending is not None:
                bound, least = product * pending[3], order + pending[4]
            if bound >= reached and (most is None or least <= most):
                # Of those that are equal to rounding the last goes on: no wave through all of them.
                entry = (-_rounded(bound), least, -next(number), product, order, chosen, pending)
                heapq.heappush(waiting, entry)

        top = self._graph.top
        if top in self._families:
            wait(1.0, 0, None, left_to_do(top, self._families[top].root, None))
        elif top == TRUE:
            wait(1.0, 0, None, None)
        elif top != FALSE:
            wait(weight[top], 1, (top, None), None)
        while waiting:
            _, _, _, product, order, chosen, pending = heapq.heappop(waiting)
            if pending is None:
                if product >= cut_off:
                    yield self._cut_set(chosen, product)
                continue
            literal, node, rest, _, _ = pending
            family = self._families[literal]
            # Down the low edges of one family all at once: each high edge is a choice.
            while node > EMPTY_SET:
                element = family.literals[family.level[node]]
                above = int(family.high[node])
                left = left_to_do(literal, above, rest) if above != EMPTY_SET else rest
                if element in self._families:
                    within = left_to_do(element, self._families[element].root, left)
                    wait(product, order, chosen, within)
                else:
                    wait(product * weight[element], order + 1, (element, chosen), left)
                node = int(family.low[node])
            if node == EMPTY_SET:
                wait(product, order, chosen, rest)

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

    def _literals(self) -> Iterator[int]:
        """Yield the literals of the events, both signs."""
        for node in range(FIRST_EVENT, self._graph.first_gate):
            yield node
            yield -node

    def _by_order(self, values: Mapping[int, float]) -> list[float]:
        """Return by order the sum over the sets of the products of their literals' values.

        With values that are all 1 these are counts, exact integers.
        """
        top = self._graph.top
        if abs(top) == TRUE:
            return [1] if top == TRUE else []
        by_order: dict[int, list[float]] = {}
        for literal, family in self._families.items():
            for element in family.literals:
                if element not in self._families:
                    by_order[element] = [0, values[element]]
            by_order[literal] = family.by_order(by_order, self.max_order)
        return by_order[top] if top in by_order else [0, values[top]]

    def _literal_values(self, values: Mapping[str, float]) -> dict[int, float]:
        literal_values = {TRUE: 1.0, FALSE: 0.0}
        for node, event in enumerate(self._graph.events, FIRST_EVENT):
            parameter = self._parameters[event]
            if parameter not in values:
                raise ModelError(
                    f"event '{event}': parameter '{parameter}' has no value; "
                    f"{one_of(values, parameter)}"
                )
            value = values[parameter]
            if not 0.0 <= value <= 1.0:
                raise ModelError(
                    f"event '{event}': probability {value!r} is outside [0, 1]; "
                    "give a number within"
                )
            literal_values[node], literal_values[-node] = pair_of(value)
        return literal_values


def _rounded(value: float) -> float:
    """Return a value to 40 bits, so that equal products in other orders of factors are equal."""
    mantissa, exponent = math.frexp(value)
    return math.ldexp(round(math.ldexp(mantissa, 40)), exponent - 40)
