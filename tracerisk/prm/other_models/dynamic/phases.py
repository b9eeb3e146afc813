"""A mission of phases that follow one another: failures stay from one phase to the next.

Own derivation, after J. Esary, H. Ziehms, "Reliability of phased missions" (1975): an event has
happened by the end of a phase if it did in that phase or in one before, and what it does in each
phase, given that it has not happened before, are independent events. So the mission is one fault
tree: that of the first phase or of the second or of any other. Missions with repaired events are
chains over the sets of failed ones, see `first_failure`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability, value_of
from tracerisk.prm.other_models.dynamic.first_failure import (
    MissionPhase,
    first_failure_in_phases,
    is_repaired,
)
from tracerisk.prm.trees.events import BasicEvent, FailureModel, HouseEvent
from tracerisk.prm.trees.failure_models import NEVER, Constant, Exponential, PerDemand
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind


def mission_probability(mission: str, phases: Sequence[MissionPhase]) -> Probability:
    """Return the probability that the top of any phase happens in it; `mission` is for messages.

    Raises ModelError for gates that are not coherent, and for events whose probability falls as
    the mission goes on, or whose laws change in a way that has no meaning; TooLargeError as
    `FaultTree` and `first_failure_in_phases` do.
    """
    for phase in phases:
        for gate in phase.tree.gates:
            if not gate.kind.is_coherent:
                raise ModelError(
                    f"gate '{gate.name}': {gate.kind.value} is not coherent, so a failure in one "
                    f"phase may be none in another; no figure of '{mission}' as a whole"
                )
    if any(is_repaired(event) for phase in phases for event in phase.exposed):
        return first_failure_in_phases(phases)
    gates: dict[str, Gate] = {}
    houses: dict[str, HouseEvent] = {}
    values: dict[str, float] = {}
    parts: dict[str, BasicEvent] = {}
    chances: dict[str, tuple[Probability, ...]] = {}
    for number, phase in enumerate(phases):
        for gate in phase.tree.gates:
            inputs = tuple(f"{number}:{name}" for name in gate.inputs)
            gates[f"{number}:{gate.name}"] = Gate(
                f"{number}:{gate.name}", gate.kind, inputs, gate.k
            )
        for house in phase.tree.houses:
            houses[f"{number}:{house.name}"] = HouseEvent(f"{number}:{house.name}", house.state)
        for event in phase.tree.events:
            if event.name not in chances:
                chances[event.name] = _in_each_phase(event.name, phases)
            until = []
            for place, pair in enumerate(chances[event.name][: number + 1]):
                if pair.p:
                    part = BasicEvent(f"{event.name} {place}", f"{event.parameter} {place}")
                    parts[part.name] = part
                    values[part.parameter] = value_of(pair)
                    until.append(part.name)
            gates[f"{number}:{event.name}"] = Gate(
                f"{number}:{event.name}", GateKind.OR, tuple(until)
            )
    tops = tuple(f"{number}:{phase.tree.top}" for number, phase in enumerate(phases))
    gates["any"] = Gate("any", GateKind.OR, tops)
    tree = FaultTree("any", tuple(gates.values()), tuple(parts.values()), tuple(houses.values()))
    return tree.probability(values)


def _in_each_phase(name: str, phases: Sequence[MissionPhase]) -> tuple[Probability, ...]:
    """Return the probability of an event in each phase, given not in one before."""
    models: Mapping[str, FailureModel | None] = {phase.name: phase.law(name) for phase in phases}
    given = [model for model in models.values() if model is not None]
    first = given[0]
    if all(model is first or model == first for model in given):
        if isinstance(first, Exponential | Constant | PerDemand) or len(given) == len(phases):
            return _of_one_law(name, first, phases)
        without = next(phase for phase, model in models.items() if model is None)
        raise ModelError(
            f"event '{name}': {type(first).__name__} counts the time of every phase, but "
            f"'{without}' does not have it; add it there, or give it a constant rate"
        )
    if all(isinstance(model, Exponential) for model in given):
        return tuple(
            NEVER if model is None else model.probability(phase.end_h - phase.begin_h)
            for phase, model in zip(phases, models.values(), strict=True)
        )
    other, model = next(
        (phase, model) for phase, model in models.items() if model is not None and model != first
    )
    one = next(phase for phase, model in models.items() if model is first)
    raise ModelError(
        f"event '{name}' is {first} in '{one}' and {model} in '{other}'; only constant rates may "
        "change from phase to phase"
    )


def _of_one_law(
    name: str, model: FailureModel, phases: Sequence[MissionPhase]
) -> tuple[Probability, ...]:
    """Return the same for a law that is the same in all phases that have the event."""
    is_throughout = all(phase.law(name) is not None for phase in phases)
    found: list[Probability] = []
    before, spent_h = NEVER, 0.0
    for phase in phases:
        if phase.law(name) is None:
            found.append(NEVER)
            continue
        spent_h = phase.end_h if is_throughout else spent_h + phase.end_h - phase.begin_h
        now = model.probability(spent_h)
        if now.p < before.p:
            raise ModelError(
                f"event '{name}': its probability falls from {before.p:g} to {now.p:g} as "
                "the mission goes on; no figure of all phases"
            )
        if before.q == 0.0:
            found.append(NEVER)
        else:
            found.append(Probability((now.p - before.p) / before.q, now.q / before.q))
        before = now
    return tuple(found)
