"""The probability that a mission ends in one way, in a chain whose every failure ends it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tracerisk.prm.hybrid.fates.ends import UNNOTICED, Way, ways_on
from tracerisk.prm.hybrid.fates.resolved import (
    LATE,
    UNDETECTED,
    Shares,
    failing_model,
    leads_back,
    undetected_model,
    unstopped_model,
)
from tracerisk.prm.hybrid.fixed_cycles import Passage, failure_of, passed
from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain
from tracerisk.prm.hybrid.hybrid import HybridModel


class EndingChain(HiddenChain):
    """A chain of whose failures only those count that end in one way."""

    def __init__(
        self, chain: HiddenChain, model: HybridModel, shares: Shares, stop: Way | None = None
    ) -> None:
        """Prepare the chain; `model` is that whose missions `chain` has.

        `shares` are what follows its failures (`resolved_shares`).
        Those failures count that lead to the `stop`; without one those that nobody notices, or
        that do harm before the stop.
        """
        super().__init__(chain.states, base=chain)
        worse = (UNNOTICED,) if stop == LATE else UNDETECTED
        states = {state.name: state for state in failing_model(model, worse, shares).states}
        self._worse = HiddenChain(
            replace(
                chain.states,
                functions=tuple(
                    replace(function, state=states[function.state.name])
                    for function in chain.states.functions
                ),
            )
        )
        self._stopping = None if stop is None else self._stops(model, shares, stop, worse)

    def _stops(
        self, model: HybridModel, shares: Shares, stop: Way, worse: Sequence[Way]
    ) -> list[float]:
        """Return the probability of a stop in each function, where nothing worse happens."""
        stops = []
        of_name = {state.name: state for state in model.states}
        for function in self.states.functions:
            state = of_name[function.state.name]
            rows = shares.get(state.name, {})
            before = {name: sum(row.get(way, 0.0) for way in worse) for name, row in rows.items()}
            ways, _ = ways_on(state, [stop], rows, state.probabilities, before)
            stops.append(float(ways[stop]))
        return stops

    def _passed(
        self, number: int, layer: int, mass: float
    ) -> tuple[float, list[tuple[int, float]]]:
        lost, ways = super()._passed(number, layer, mass)
        is_held = layer < len(self.states.hidden)
        if self._stopping is not None:
            visit = self._worse.visit(number, layer) if is_held else None
            return (mass * visit.q * self._stopping[number] if visit else 0.0), ways
        return (min(lost, mass * self._worse.visit(number, layer).p) if is_held else lost), ways

    def failure(self, passage: Passage | None) -> float:
        """Return how likely a mission ends so, one with a fixed passage where it is given."""
        if passage is None:
            return failure_of(self.flow())
        start: Sequence[float] = [1.0]
        return passed(self, passage, start)[1]


def bounding_model(model: HybridModel) -> HybridModel:
    """Return a model whose failure bounds the undetected one from above, to be solved by groups."""
    return undetected_model(model) if leads_back(model) else unstopped_model(model)
