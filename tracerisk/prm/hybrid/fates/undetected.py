"""The probability that a mission fails unnoticed, or does harm before its controller stops it."""

from __future__ import annotations

from collections.abc import Sequence

from tracerisk.prm.hybrid.fates.resolved import (
    leads_back,
    undetected_model,
    unstopped_model,
)
from tracerisk.prm.hybrid.fixed_cycles import Passage, failure_of, passed
from tracerisk.prm.hybrid.hidden.hidden_chain import HiddenChain
from tracerisk.prm.hybrid.hidden.hidden_states import MOST_STATES, hidden_states
from tracerisk.prm.hybrid.hybrid import HybridModel


class UndetectedChain(HiddenChain):
    """A chain of whose failures only those count that nobody notices."""

    def __init__(self, chain: HiddenChain, model: HybridModel, limit: int = MOST_STATES) -> None:
        """Prepare the chain; `model` is that whose missions `chain` has."""
        super().__init__(chain.states, base=chain)
        states = hidden_states(undetected_model(model), limit)
        self._undetected = HiddenChain(states)

    def _passed(
        self, number: int, layer: int, mass: float
    ) -> tuple[float, list[tuple[int, float]]]:
        lost, ways = super()._passed(number, layer, mass)
        if layer < len(self.states.hidden):
            lost = min(lost, mass * self._undetected.visit(number, layer).p)
        return lost, ways

    def failure(self, passage: Passage | None) -> float:
        """Return the undetected failure of a mission, of one with a fixed passage where given."""
        if passage is None:
            return failure_of(self.flow())
        start: Sequence[float] = [1.0]
        return passed(self, passage, start)[1]


def bounding_model(model: HybridModel) -> HybridModel:
    """Return a model whose failure bounds the undetected one from above, to be solved by groups."""
    return undetected_model(model) if leads_back(model) else unstopped_model(model)
