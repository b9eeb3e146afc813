"""Whether the top of a tree of repaired events happens at any time of a mission.

A repaired event may be well again at the end of the mission, and so may the top. That it happens
at all is a question to the Markov chain over the sets of failed events, in which the top's
failure is not left (own derivation; the chain is that of M. Rausand, A. Hoyland, "System
Reliability Theory", 2nd ed. (2004), chapter 8).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.numbers.quantities import check_mission_time
from tracerisk.prm.other_models.dynamic.failure_chain import FailureChain
from tracerisk.prm.trees.events import FailureModel
from tracerisk.prm.trees.failure_models import GLM, NEVER, Constant, Exponential, PerDemand
from tracerisk.prm.trees.gates import Gate, swept

if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.tree import DynamicTree

ALWAYS = NEVER.complement
MOST_EVENTS = 14
"""The most events of a tree that is followed: 16,384 sets of failed ones."""


def has_repair(tree: DynamicTree) -> bool:
    """Return whether an event of a tree is repaired."""
    return any(isinstance(event.model, GLM) and event.model.repair_rate for event in tree.events)


def without_repair(tree: DynamicTree) -> DynamicTree:
    """Return a tree whose events stay failed, and so whose top happens no less often.

    It holds for trees of Galileo, whose events are sound at the start and whose gates are coherent.
    """
    return replace(
        tree,
        events=tuple(
            replace(event, model=Exponential(event.model.failure_rate))
            if isinstance(event.model, GLM) and event.model.failure_on_demand == 0.0
            else event
            for event in tree.events
        ),
    )


def first_failure(tree: DynamicTree, mission_time_h: float) -> Probability:
    """Return the probability that the top happens at any time of the mission, [h].

    Each failed event is repaired by itself, whatever else has failed.
    Raises ModelError for gates for which order counts, dependencies, restrictions and events
    whose rates are not constant, and TooLargeError for more than 14 events.
    """
    check_mission_time(mission_time_h)
    for gate in tree.upwards:
        if not isinstance(gate, Gate):
            raise ModelError(f"gate '{gate.name}': {gate.kind.value} has no meaning with repair")
    for tie in tree.ties:
        raise ModelError(f"'{tie.name}': dependencies and restrictions have no meaning with repair")
    if len(tree.events) > MOST_EVENTS:
        raise TooLargeError(
            f"{len(tree.events)} events; the first failure of a tree with repair is found for up "
            f"to {MOST_EVENTS}"
        )
    laws = [_law(event.name, event.model) for event in tree.events]
    failed_at_start: dict[int, float] = {0: 1.0}
    for number, (at_start, _, _) in enumerate(laws):
        failed_at_start = {
            failed | (bit << number): share * chance
            for failed, share in failed_at_start.items()
            for bit, chance in ((0, 1.0 - at_start), (1, at_start))
            if chance
        }
    numbers: dict[int, int] = {}
    waiting: list[int] = []

    def state_of(failed: int) -> int:
        """Return the number of a set of failed events, 0 where the top has happened."""
        if failed not in numbers:
            happens = _happens(tree, failed)
            numbers[failed] = 0 if happens else len(waiting) + 1
            if not happens:
                waiting.append(failed)
        return numbers[failed]

    start = [(state_of(failed), share) for failed, share in failed_at_start.items()]
    transitions: list[tuple[int, int, float]] = []
    for source, failed in enumerate(waiting, 1):
        for number, (_, failing, repairing) in enumerate(laws):
            rate = repairing if failed >> number & 1 else failing
            if rate:
                transitions.append((source, state_of(failed ^ 1 << number), rate))
    if not waiting:
        return ALWAYS
    if 0 not in numbers.values():
        return NEVER
    chain = FailureChain(len(waiting) + 1, tuple(start), tuple(transitions))
    return chain.failed_by(mission_time_h)


def _law(name: str, model: FailureModel) -> tuple[float, float, float]:
    """Return the probability of being failed at the start, the failure and the repair rate."""
    if isinstance(model, GLM):
        return model.failure_on_demand, model.failure_rate, model.repair_rate
    if isinstance(model, Exponential):
        return 0.0, model.rate, 0.0
    if isinstance(model, Constant | PerDemand):
        return model.probability(0.0).p, 0.0, 0.0
    raise ModelError(
        f"event '{name}': {type(model).__name__} has no constant rate, which the first failure of "
        "a tree with repair needs; allowed: Constant, Exponential, GLM, PerDemand"
    )


def _happens(tree: DynamicTree, failed: int) -> bool:
    gates = [gate for gate in tree.upwards if isinstance(gate, Gate)]
    nodes = {
        event.name: ALWAYS if failed >> number & 1 else NEVER
        for number, event in enumerate(tree.events)
    }
    return swept(gates, nodes)[tree.top].p > 0.5
