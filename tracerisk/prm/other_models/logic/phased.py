"""A mission of phases that follow one another: failures stay from one phase to the next.

Own derivation, after J. Esary, H. Ziehms, "Reliability of phased missions" (1975): an event has
happened by the end of a phase if it did in that phase or in one before, and what it does in each
phase, given that it has not happened before, are independent events. So the mission is one fault
tree: that of the first phase or of the second or of any other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability, value_of
from tracerisk.prm.other_models.expressions import Expression, ExpressionModel, Reference
from tracerisk.prm.other_models.expressions.laws import Glm
from tracerisk.prm.other_models.expressions.laws import PeriodicTest as TestedExpression
from tracerisk.prm.other_models.logic.common_cause import ShareOf
from tracerisk.prm.other_models.logic.mission_parts import Alignment
from tracerisk.prm.other_models.logic.model import LogicModel
from tracerisk.prm.trees.events import BasicEvent, FailureModel, HouseEvent
from tracerisk.prm.trees.failure_models import GLM, NEVER, PeriodicTest
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind


def phased_probability(
    model: LogicModel, alignment: Alignment, top: str, mission_time_h: float
) -> Probability:
    """Return the probability that a top happens in any phase of a mission, [h].

    The phases follow one another in their order, each for its fraction of the mission.
    Raises ModelError for gates that are not coherent, for repaired or tested events, and for
    events whose probability falls as the mission goes on; TooLargeError as `FaultTree` does.
    """
    trees = [
        model.in_phase(alignment.name, phase.name).fault_tree(top, mission_time_h=mission_time_h)
        for phase in alignment.phases
    ]
    ends, elapsed = [], 0.0
    for phase in alignment.phases:
        elapsed += phase.fraction
        ends.append(min(elapsed, 1.0) * mission_time_h)
    gates: dict[str, Gate] = {}
    houses: dict[str, HouseEvent] = {}
    values: dict[str, float] = {}
    parts: dict[str, BasicEvent] = {}
    for number, (phase, tree) in enumerate(zip(alignment.phases, trees, strict=True)):
        for gate in tree.gates:
            if not gate.kind.is_coherent:
                raise ModelError(
                    f"gate '{gate.name}': {gate.kind.value} is not coherent, so a failure in one "
                    f"phase may be none in another; no figure of '{alignment.name}' as a whole"
                )
            inputs = tuple(f"{number}:{name}" for name in gate.inputs)
            gates[f"{number}:{gate.name}"] = Gate(
                f"{number}:{gate.name}", gate.kind, inputs, gate.k
            )
        for house in tree.houses:
            houses[f"{number}:{house.name}"] = HouseEvent(f"{number}:{house.name}", house.state)
        for event in tree.events:
            until = []
            for place, pair in enumerate(_in_phases(event, ends[: number + 1], phase.name)):
                if pair.p:
                    part = BasicEvent(f"{event.name} {place}", f"{event.parameter} {place}")
                    parts[part.name] = part
                    values[part.parameter] = value_of(pair)
                    until.append(part.name)
            gates[f"{number}:{event.name}"] = Gate(
                f"{number}:{event.name}", GateKind.OR, tuple(until)
            )
    tops = tuple(f"{number}:{tree.top}" for number, tree in enumerate(trees))
    gates["any"] = Gate("any", GateKind.OR, tops)
    tree = FaultTree("any", tuple(gates.values()), tuple(parts.values()), tuple(houses.values()))
    return tree.probability(values)


def _in_phases(event: BasicEvent, ends: Sequence[float], phase: str) -> Iterator[Probability]:
    """Yield the probability of an event in each phase that ends, given not in one before."""
    model = event.model
    if model is None:
        raise ModelError(f"event '{event.name}' has no figure; give it one")
    if _is_repaired(model):
        raise ModelError(
            f"event '{event.name}' is repaired or tested, and may have happened in one phase and "
            f"not in '{phase}'; give it a law without repair for a figure of all phases"
        )
    before = NEVER
    for end in ends:
        now = model.probability(end)
        if now.p < before.p:
            raise ModelError(
                f"event '{event.name}': its probability falls from {before.p:g} to {now.p:g} as "
                "the mission goes on; no figure of all phases"
            )
        if before.q == 0.0:
            yield NEVER
        else:
            yield Probability((now.p - before.p) / before.q, now.q / before.q)
        before = now


def _is_repaired(model: FailureModel) -> bool:
    if isinstance(model, ShareOf):
        return _is_repaired(model.model)
    if not isinstance(model, ExpressionModel):
        return isinstance(model, GLM | PeriodicTest)
    waiting, seen = [model.expression], set()
    while waiting:
        expression = waiting.pop()
        if isinstance(expression, Glm | TestedExpression):
            return True
        if not isinstance(expression, Reference):
            waiting += expression.arguments
        elif expression.name not in seen:
            seen.add(expression.name)
            known = model.definitions.by_name.get(expression.name)
            waiting += [known] if isinstance(known, Expression) else []
    return False
