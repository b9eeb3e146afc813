"""Whether the top of a tree of repaired events happens at any time of a mission.

A repaired event may be well again at the end of the mission, and so may the top. That it happens
at all is a question to the Markov chain over the sets of failed events, in which the top's
failure is not left (own derivation; the chain is that of M. Rausand, A. Hoyland, "System
Reliability Theory", 2nd ed. (2004), chapter 8).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.numbers.quantities import check_mission_time
from tracerisk.prm.other_models.dynamic.failure_chain import FailureChain
from tracerisk.prm.other_models.markov.uniformisation import after_time
from tracerisk.prm.trees.events import BasicEvent, FailureModel
from tracerisk.prm.trees.failure_models import GLM, NEVER, Constant, Exponential, PerDemand
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, swept

if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.elements import DynamicEvent
    from tracerisk.prm.other_models.dynamic.tree import DynamicTree

ALWAYS = NEVER.complement
MOST_EVENTS = 14
"""The most events of a tree that is followed: 16,384 sets of failed ones."""


@dataclass(frozen=True, slots=True)
class MissionPhase:
    """A part of a mission in which one tree says what fails it."""

    name: str
    """Name of the phase, for messages."""
    tree: FaultTree
    """The tree whose top fails the mission in this phase; its events have failure models."""
    begin_h: float
    """When it begins, after the mission did [h]."""
    end_h: float
    """When it ends, after the mission began [h]."""
    exposed: tuple[BasicEvent, ...]
    """The events that can happen in it, with their laws, whether its tree has them or not."""

    def law(self, name: str) -> FailureModel | None:
        """Return the law of an event in this phase; `None` where it cannot happen."""
        for event in self.exposed:
            if event.name == name:
                if event.model is None:
                    raise ModelError(f"event '{name}' has no figure; give it one")
                return event.model
        return None


def is_repaired(event: BasicEvent | DynamicEvent) -> bool:
    """Return whether an event is repaired."""
    return isinstance(event.model, GLM) and event.model.repair_rate > 0.0


def has_repair(tree: DynamicTree) -> bool:
    """Return whether an event of a tree is repaired."""
    return any(map(is_repaired, tree.events))


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
    static = tree.static_tree()
    whole = MissionPhase("the mission", static, 0.0, mission_time_h, static.events)
    return first_failure_in_phases([whole])


def first_failure_in_phases(phases: Sequence[MissionPhase]) -> Probability:
    """Return the probability that the top of any phase happens in it, at any time.

    What has failed in one phase and is not repaired is failed in the next.
    Raises ModelError for events whose rates are not constant or that are repaired in one phase
    and missing in another, and TooLargeError for more than 14 events.
    """
    names = list(
        dict.fromkeys(
            event.name for phase in phases for event in (*phase.exposed, *phase.tree.events)
        )
    )
    if len(names) > MOST_EVENTS:
        raise TooLargeError(
            f"{len(names)} events; the first failure of a tree with repair is found for up "
            f"to {MOST_EVENTS}"
        )
    laws = [[_law_in(phase, name, phases) for name in names] for phase in phases]
    working: dict[int, float] = {0: 1.0}
    for number, name in enumerate(names):
        at_start = _at_start(name, [row[number] for row in laws], phases)
        working = {
            failed | (bit << number): share * chance
            for failed, share in working.items()
            for bit, chance in ((0, 1.0 - at_start), (1, at_start))
            if chance
        }
    lost = 0.0
    for phase, row in zip(phases, laws, strict=True):
        sets, chain = _chain(phase, names, [law or _ABSENT for law in row], lost, working)
        hours = phase.end_h - phase.begin_h
        if phase is phases[-1]:
            break
        rates: list[dict[int, float]] = [{} for _ in range(chain.states)]
        for source, target, rate in chain.transitions:
            rates[source][target] = rates[source].get(target, 0.0) + rate
        begun = [0.0] * chain.states
        for state, share in chain.initial:
            begun[state] += share
        lost, *shares = after_time(rates, begun, hours)
        working = dict(zip(sets, shares, strict=True))
    if not sets:
        return ALWAYS
    if lost == 0.0 and not _is_lost(chain):
        return NEVER
    return chain.failed_by(hours)


def _is_lost(chain: FailureChain) -> bool:
    """Return whether a chain begins in its failure, or comes to it."""
    return any(state == 0 for state, _ in chain.initial) or any(
        target == 0 for _, target, _ in chain.transitions
    )


_Law = tuple[float, float, float]
"""The probability of being failed at the start, the failure rate and the repair rate [1/h]."""
_ABSENT: _Law = (0.0, 0.0, 0.0)


def _chain(
    phase: MissionPhase,
    names: Sequence[str],
    laws: Sequence[_Law],
    lost: float,
    working: dict[int, float],
) -> tuple[list[int], FailureChain]:
    """Return the chain of a phase, and the sets of failed events that its states 1, 2... are.

    What was lost before, and what the phase's top happens for, is in its state 0.
    """
    numbers: dict[int, int] = {}
    sets: list[int] = []

    def state_of(failed: int) -> int:
        """Return the number of a set of failed events, 0 where the top has happened."""
        if failed not in numbers:
            happens = _happens(phase.tree, names, failed)
            numbers[failed] = 0 if happens else len(sets) + 1
            if not happens:
                sets.append(failed)
        return numbers[failed]

    initial = [(0, lost)] if lost else []
    initial += [(state_of(failed), share) for failed, share in working.items() if share]
    transitions: list[tuple[int, int, float]] = []
    for source, failed in enumerate(sets, 1):
        for number, (_, failing, repairing) in enumerate(laws):
            rate = repairing if failed >> number & 1 else failing
            if rate:
                transitions.append((source, state_of(failed ^ 1 << number), rate))
    return sets, FailureChain(len(sets) + 1, tuple(initial), tuple(transitions))


def _law_in(phase: MissionPhase, name: str, phases: Sequence[MissionPhase]) -> _Law | None:
    """Return the law of an event in a phase; `None` where it cannot happen in it."""
    model = phase.law(name)
    if model is not None:
        return _law(name, model)
    for other in phases:
        if any(event.name == name and is_repaired(event) for event in other.exposed):
            raise ModelError(
                f"event '{name}' is repaired in '{other.name}', and '{phase.name}' does not have "
                "it; add it there, so that it is known how it is repaired"
            )
    return None


def _at_start(name: str, laws: Sequence[_Law | None], phases: Sequence[MissionPhase]) -> float:
    """Return the probability of being failed when the mission begins."""
    shares = {law[0]: phase.name for law, phase in zip(laws, phases, strict=True) if law}
    if len(shares) > 1:
        (one, first), (other, second), *_ = shares.items()
        raise ModelError(
            f"event '{name}' is failed at the start with {one:g} by '{first}' and with {other:g} "
            f"by '{second}'; give it one probability"
        )
    return next(iter(shares))


def _law(name: str, model: FailureModel) -> _Law:
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


def _happens(tree: FaultTree, names: Sequence[str], failed: int) -> bool:
    nodes = {name: ALWAYS if failed >> number & 1 else NEVER for number, name in enumerate(names)}
    nodes |= {house.name: ALWAYS if house.state else NEVER for house in tree.houses}
    return swept(tree.upwards, nodes)[tree.top].p > 0.5
