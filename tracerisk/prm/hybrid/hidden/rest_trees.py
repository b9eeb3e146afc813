"""The trees of a chain's functions less the latent units: what each parameter does there.

Where nothing is shared and a parameter has one event, the top is linear in it, and one pass over
the tree gives the effect of every parameter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.errors import ModelError
from tracerisk.prm.hybrid.hidden.hidden_states import Function
from tracerisk.prm.numbers.probability import Probability, pair_of
from tracerisk.prm.trees.conditional_tops import Conditional
from tracerisk.prm.trees.fault_tree import FaultTree


class RestTrees:
    """The trees of functions, by number, each with the values of its parameters."""

    def __init__(
        self, functions: Sequence[Function], values: Sequence[Mapping[str, float]]
    ) -> None:
        self._functions, self._values = functions, values
        self._drops: dict[tuple[int, str], float] = {}
        self._sensitivities: dict[int, Mapping[str, float]] = {}
        self._conditionals: dict[int, Mapping[str, Conditional]] = {}
        self._events: dict[int, dict[str, list[str]]] = {}

    def failure(self, number: int) -> Probability:
        """Return the probability that a tree fails; raise ModelError where it cannot be solved."""
        return self._probability(number, self._values[number])

    def failure_at(self, number: int, name: str, value: float) -> Probability:
        """Return the probability that a tree fails with another value of a parameter."""
        tree, event = self._functions[number].rest, self._only_event(number, name)
        if event is None:
            return self._probability(number, {**self._values[number], name: value})
        if number not in self._conditionals:
            self._conditionals[number] = tree.conditional_tops(self._values[number])
        given, without = self._conditionals[number][event]
        p, q = pair_of(value)
        return Probability(p * given.p + q * without.p, p * given.q + q * without.q)

    def events(self, number: int, name: str) -> Sequence[str]:
        """Return the events of a parameter."""
        if number not in self._events:
            events: dict[str, list[str]] = {}
            for event in self._functions[number].rest.events:
                events.setdefault(event.parameter, []).append(event.name)
            self._events[number] = events
        return self._events[number].get(name, ())

    def sensitivities(self, number: int) -> Mapping[str, float]:
        """Return the derivative of a tree's failure by each of its events."""
        if number not in self._sensitivities:
            tree = self._functions[number].rest
            self._sensitivities[number] = tree.sensitivities(self._values[number])
        return self._sensitivities[number]

    def drop(self, number: int, name: str) -> float:
        """Return how much less a tree fails without a parameter."""
        key = (number, name)
        if key not in self._drops:
            event = self._only_event(number, name)
            if event is not None:
                drop = self._values[number][name] * self.sensitivities(number)[event]
            elif self.events(number, name):
                drop = self._functions[number].rest.drop_without(name, self._values[number])
            else:
                drop = 0.0
            self._drops[key] = drop
        return self._drops[key]

    def _only_event(self, number: int, name: str) -> str | None:
        """Return a parameter's event if it is the only one and the tree shares nothing."""
        events = self.events(number, name)
        is_linear = len(events) == 1 and not self._functions[number].rest.shared
        return events[0] if is_linear else None

    def _probability(self, number: int, values: Mapping[str, float]) -> Probability:
        function = self._functions[number]
        return tree_probability(function.state.name, function.rest, values)


def tree_probability(state: str, tree: FaultTree, values: Mapping[str, float]) -> Probability:
    """Return the top's probability; raise ModelError with the state where it cannot be had."""
    try:
        return tree.probability(values)
    except ModelError as error:
        raise ModelError(f"state '{state}': {error.message}", error.location) from error
