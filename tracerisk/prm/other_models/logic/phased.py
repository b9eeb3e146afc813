"""A model of Open-PSA through the phases of an alignment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.dynamic.first_failure import MissionPhase, is_repaired
from tracerisk.prm.other_models.dynamic.phases import mission_probability
from tracerisk.prm.other_models.expressions import (
    Evaluation,
    Expression,
    ExpressionModel,
    Reference,
)
from tracerisk.prm.other_models.expressions.laws import Glm
from tracerisk.prm.other_models.expressions.laws import PeriodicTest as TestedExpression
from tracerisk.prm.other_models.logic.common_cause import ShareOf
from tracerisk.prm.other_models.logic.failure_laws import failure_law
from tracerisk.prm.other_models.logic.mission_parts import Alignment
from tracerisk.prm.other_models.logic.model import LogicModel
from tracerisk.prm.trees.events import BasicEvent, FailureModel
from tracerisk.prm.trees.failure_models import GLM, PeriodicTest


def phased_probability(
    model: LogicModel, alignment: Alignment, top: str, mission_time_h: float
) -> Probability:
    """Return the probability that a top happens in any phase of a mission, [h].

    The phases follow one another in their order, each for its fraction of the mission.
    Raises ModelError for tested events, for those that are repaired other than at a constant rate,
    and as `mission_probability` does; TooLargeError as that does.
    """
    trees = [
        model.in_phase(alignment.name, phase.name).fault_tree(top, mission_time_h=mission_time_h)
        for phase in alignment.phases
    ]
    exposed = {event.name: event for tree in trees for event in tree.events}
    units = _with_repair(tuple(exposed.values()), model, mission_time_h)
    phases, elapsed, begin_h = [], 0.0, 0.0
    for phase, tree in zip(alignment.phases, trees, strict=True):
        elapsed += phase.fraction
        end_h = min(elapsed, 1.0) * mission_time_h
        phases.append(MissionPhase(phase.name, tree, begin_h, end_h, units))
        begin_h = end_h
    return mission_probability(alignment.name, phases)


def _with_repair(
    events: Sequence[BasicEvent], model: LogicModel, mission_time_h: float
) -> tuple[BasicEvent, ...]:
    """Return events, with the laws that they have by name if any of them is repaired."""
    evaluation = Evaluation(model.definitions.by_name, mission_time_h)
    named: list[BasicEvent] = []
    for event in events:
        if event.model is None:
            raise ModelError(f"event '{event.name}' has no figure; give it one")
        law = failure_law(event.model, model, evaluation)
        if law is None and _is_repaired(event.model):
            raise ModelError(
                f"event '{event.name}' is tested, or repaired at no constant rate, and may have "
                "happened in one phase and not in the next; for a figure of all phases, give it "
                "GLM or a law without repair"
            )
        named.append(event if law is None else replace(event, model=law))
    return tuple(named if any(map(is_repaired, named)) else events)


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
