"""A fault tree that shares events or gates, made ready to be solved for many values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate
from operator import mul

from tracerisk.errors import ModelError, TooLargeError, one_of
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.bdd.diagram import (
    DEFAULT_LIMITS,
    Diagram,
    Limits,
    build_diagram,
    module_pair,
)
from tracerisk.prm.trees.bdd.logic import FALSE, FIRST_EVENT, TRUE, LogicGraph, logic_graph
from tracerisk.prm.trees.bdd.modules import Module, grouped, modules
from tracerisk.prm.trees.bdd.simplify import simplified

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tracerisk.prm.trees.fault_tree import FaultTree

EventValues = Mapping[str, Probability]
"""The probability of each basic event, by its name."""


class SharedTree:
    """A compiled fault tree: modules in closed form or with a decision diagram each.

    Raises TooLargeError when a module's diagram outgrows every budget of `limits`.
    """

    def __init__(self, tree: FaultTree, limits: Limits = DEFAULT_LIMITS) -> None:
        self.limits = limits
        self.graph: LogicGraph = grouped(simplified(logic_graph(tree)))
        self.modules: tuple[Module, ...]
        self.diagrams: dict[int, Diagram]
        try:
            self._compile()
            # A part that always or never happens is seen only by its diagram.
            while constants := self._constants():
                self.graph = grouped(simplified(self.graph.with_constants(constants)))
                self._compile()
        except TooLargeError as error:
            raise TooLargeError(
                f"fault tree '{tree.top}': {error.message}", lower=error.lower, upper=error.upper
            ) from error

    def _compile(self) -> None:
        self.modules = modules(self.graph)
        self.diagrams = {
            module.root: build_diagram(self.graph, module, self.limits)
            for module in self.modules
            if not module.is_simple
        }

    def _constants(self) -> dict[int, int]:
        """Return the modules that always or never happen, with TRUE or FALSE."""
        edges = {0: TRUE, 1: FALSE}
        return {
            node: edges[diagram.root]
            for node, diagram in self.diagrams.items()
            if diagram.root in edges
        }

    def probability(self, values: EventValues) -> Probability:
        """Return the top event's probability, exact to rounding."""
        p, q = self._sweep(values)
        top = abs(self.graph.top)
        pair = Probability(p[top], q[top])
        return pair if self.graph.top > 0 else pair.complement

    def probabilities(self, values: Mapping[str, Any]) -> Any:
        """Return the top's probability and its complement for n samples of the events' values.

        values: by event (n,) probabilities; one number stands for n equal ones.
        Returns (n, 2).
        Raises ModelError when an event has no value or one outside [0, 1].
        """
        samples = np.broadcast_shapes((1,), *(np.shape(value) for value in values.values()))
        p: list[Any] = [None] * len(self.graph.arguments)
        q: list[Any] = [None] * len(self.graph.arguments)
        p[TRUE], q[TRUE] = np.ones(samples), np.zeros(samples)
        for node, event in enumerate(self.graph.events, FIRST_EVENT):
            if event not in values:
                raise ModelError(f"event '{event}' has no value; {one_of(values)}")
            given = np.asarray(values[event], dtype=np.float64)
            if not np.all((given >= 0.0) & (given <= 1.0)):
                raise ModelError(
                    f"event '{event}': a probability is outside [0, 1]; give numbers within"
                )
            p[node] = np.broadcast_to(given, samples)
            q[node] = 1.0 - p[node]
        for module in self.modules:
            diagram = self.diagrams.get(module.root)
            if diagram is None:
                happens, fails = np.ones(samples), np.zeros(samples)
                for argument in self.graph.arguments[module.root]:
                    node = abs(argument)
                    p_a, q_a = (p[node], q[node]) if argument > 0 else (q[node], p[node])
                    happens, fails = happens * p_a, fails + happens * q_a
            else:
                p_rows, q_rows = (np.stack([s[node] for node in diagram.order]) for s in (p, q))
                happens, fails = diagram.sweep_many(p_rows, q_rows, self.limits)
            p[module.root], q[module.root] = happens, fails
        top = abs(self.graph.top)
        sides = (p[top], q[top]) if self.graph.top > 0 else (q[top], p[top])
        return np.stack(sides, axis=1)

    def sensitivities(self, values: EventValues) -> dict[str, float]:
        """Return for each basic event the derivative of the top's probability by its own.

        Within a module by its diagram, between modules by the chain rule: of a coherent tree only
        products and sums of one sign.
        """
        p, q = self._sweep(values)
        weights = [0.0] * len(p)
        weights[abs(self.graph.top)] = 1.0 if self.graph.top > 0 else -1.0
        for module in reversed(self.modules):
            weight = weights[module.root]
            diagram = self.diagrams.get(module.root)
            if diagram is None:
                arguments = self.graph.arguments[module.root]
                sides = [(p if a > 0 else q)[abs(a)] for a in arguments]
                for argument, share in zip(arguments, _shares(sides, sides), strict=True):
                    weights[abs(argument)] = weight * share * (1.0 if argument > 0 else -1.0)
            else:
                order = diagram.order
                derivatives = diagram.derivatives(
                    [p[node] for node in order], [q[node] for node in order], self.limits
                )
                for node, share in zip(order, derivatives, strict=True):
                    weights[node] = weight * share
        # An event that the top does not depend on has a weight of zero, never minus zero.
        return {
            event: weights[node] + 0.0 for node, event in enumerate(self.graph.events, FIRST_EVENT)
        }

    def difference(self, high: EventValues, low: EventValues) -> float:
        """Return the top's probability with `high` less that with `low`, without cancellation.

        For a coherent tree every term has the sign of its event's change; see
        `docs/theory.md`, "Shared events".
        """
        p_high, q_high = self._sweep(high)
        p_low, q_low = self._sweep(low)
        drops = [0.0] * len(p_high)
        for node, event in enumerate(self.graph.events, FIRST_EVENT):
            drops[node] = high[event].p - low[event].p
        for module in self.modules:
            drops[module.root] = self._module_drop(module, (p_high, q_high), (p_low, q_low), drops)
        drop = drops[abs(self.graph.top)]
        return drop if self.graph.top > 0 else 0.0 - drop

    def _module_drop(
        self,
        module: Module,
        high: tuple[list[float], list[float]],
        low: tuple[list[float], list[float]],
        drops: Sequence[float],
    ) -> float:
        diagram = self.diagrams.get(module.root)
        if diagram is None:
            arguments = self.graph.arguments[module.root]
            before = [high[0 if a > 0 else 1][abs(a)] for a in arguments]
            after = [low[0 if a > 0 else 1][abs(a)] for a in arguments]
            signed = [drops[abs(a)] if a > 0 else -drops[abs(a)] for a in arguments]
            return float(sum(map(mul, _shares(before, after), signed)))
        order = diagram.order
        return diagram.difference(
            ([high[0][node] for node in order], [high[1][node] for node in order]),
            ([low[0][node] for node in order], [low[1][node] for node in order]),
            [drops[node] for node in order],
            self.limits,
        )

    def _sweep(self, values: EventValues) -> tuple[list[float], list[float]]:
        """Return (p, 1-p) of each event and module of the graph, by node."""
        size = len(self.graph.arguments)
        p, q = [0.0] * size, [0.0] * size
        p[TRUE] = 1.0
        for node, event in enumerate(self.graph.events, FIRST_EVENT):
            p[node], q[node] = values[event]
        for module in self.modules:
            root = module.root
            p[root], q[root] = module_pair(self.graph, module, self.diagrams.get(root), p, q)
        return p, q


def _shares(before: Sequence[float], after: Sequence[float]) -> list[float]:
    """Return for each factor of a product those before it, from `before`, times those after it."""
    heads = list(accumulate(before[:-1], mul, initial=1.0))
    tails = list(accumulate(after[:0:-1], mul, initial=1.0))
    return [head * tail for head, tail in zip(heads, reversed(tails), strict=True)]


def with_bounds(
    error: TooLargeError, tree: FaultTree, values: EventValues, limits: Limits = DEFAULT_LIMITS
) -> TooLargeError:
    """Return the error that a tree outgrew its budgets, with bounds of its probability.

    Where more than four modules outgrew them there are none, and the error stays as it is.
    """
    from tracerisk.prm.trees.bdd.bounds import tree_bounds

    try:
        lower, upper = tree_bounds(tree, values, limits)
    except TooLargeError:
        return error
    return TooLargeError(
        f"{error.message}; the probability is between {lower!r} and {upper!r}",
        error.location,
        lower=lower,
        upper=upper,
    )
