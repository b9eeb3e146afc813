"""An expression as a list of steps, evaluated forwards and differentiated backwards."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.expressions.rules import change, pair_of, partials
from tracerisk.prm.other_models.linked.links import leaf_key

Lookup = Callable[[Expression], Probability]


@dataclass(frozen=True, slots=True)
class Tape:
    """The nodes of an expression, each after its arguments."""

    nodes: tuple[Expression, ...]
    """The nodes; the expression itself comes last, (n_nodes,)."""
    places: tuple[tuple[int, ...], ...]
    """Indices of the arguments of each node, (n_nodes, n_arguments of the node)."""
    varies: tuple[bool, ...]
    """Whether each node depends on an element of the model, (n_nodes,)."""

    @classmethod
    def of(cls, expression: Expression) -> Tape:
        """Return the tape of an expression; equal parts of it stand there once."""
        nodes: list[Expression] = []
        places: list[tuple[int, ...]] = []
        known: dict[int, int] = {}
        stack = [(expression, False)]
        while stack:
            node, ready = stack.pop()
            if id(node) in known:
                continue
            if not ready:
                stack.append((node, True))
                stack.extend((argument, False) for argument in reversed(node.arguments))
                continue
            known[id(node)] = len(nodes)
            places.append(tuple(known[id(argument)] for argument in node.arguments))
            nodes.append(node)
        varies: list[bool] = []
        for node, below in zip(nodes, places, strict=True):
            varies.append(leaf_key(node) is not None or any(varies[place] for place in below))
        return cls(tuple(nodes), tuple(places), tuple(varies))

    @property
    def leaves(self) -> tuple[Expression, ...]:
        """The nodes that refer to elements of the model."""
        return tuple(node for node in self.nodes if leaf_key(node) is not None)

    def values(self, lookup: Lookup, mission_time_h: float) -> tuple[Probability, ...]:
        """Return the value of each node as a pair, that of the expression last."""
        probabilities: list[Probability] = []
        for node, places in zip(self.nodes, self.places, strict=True):
            if leaf_key(node) is not None:
                probabilities.append(lookup(node))
            else:
                probabilities.append(
                    pair_of(node, [probabilities[place] for place in places], mission_time_h)
                )
        return tuple(probabilities)

    def pull(
        self, values: tuple[Probability, ...], weight: float, mission_time_h: float
    ) -> list[tuple[Expression, float]]:
        """Return what each leaf contributes to a figure that has the derivative `weight` by this.

        The chain rule from the last node to the first.
        """
        weights = [0.0] * len(self.nodes)
        weights[-1] = weight
        leaves = []
        for index in reversed(range(len(self.nodes))):
            node, places = self.nodes[index], self.places[index]
            if weights[index] == 0.0 or not self.varies[index]:
                continue
            if leaf_key(node) is not None:
                leaves.append((node, weights[index]))
            elif places:
                arguments = [values[place] for place in places]
                wanted = [self.varies[place] for place in places]
                slopes = partials(node, arguments, mission_time_h, wanted)
                for place, slope in zip(places, slopes, strict=True):
                    weights[place] += weights[index] * slope
        return leaves

    def change(
        self,
        high: tuple[Probability, ...],
        low: tuple[Probability, ...],
        changes: Mapping[Expression, float],
        mission_time_h: float,
    ) -> float:
        """Return the expression's value in `high` less that in `low`.

        `changes` are the exact differences of the leaves; those that are not there are zero.
        """
        grown: list[float] = []
        for node, places in zip(self.nodes, self.places, strict=True):
            if leaf_key(node) is not None:
                grown.append(changes.get(node, 0.0))
            elif not any(grown[place] for place in places):
                grown.append(0.0)
            else:
                grown.append(
                    change(
                        node,
                        [high[place] for place in places],
                        [low[place] for place in places],
                        [grown[place] for place in places],
                        mission_time_h,
                    )
                )
        return grown[-1]
