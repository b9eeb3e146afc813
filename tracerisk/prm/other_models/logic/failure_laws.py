"""The failure model that the expression of an event's figure is."""

from __future__ import annotations

from tracerisk.prm.other_models.expressions import (
    Evaluation,
    Expression,
    ExpressionModel,
    MissionTime,
    Reference,
    depends_on_mission_time,
)
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, Weibull
from tracerisk.prm.other_models.logic.common_cause import ShareOf
from tracerisk.prm.other_models.logic.model import LogicModel
from tracerisk.prm.trees import failure_models
from tracerisk.prm.trees.events import FailureModel


def failure_law(
    model: FailureModel, owner: LogicModel, evaluation: Evaluation
) -> FailureModel | None:
    """Return the failure model that a figure is; `None` where it is none that has a name."""
    if isinstance(model, ShareOf):
        whole = failure_law(model.model, owner, evaluation)
        if isinstance(whole, failure_models.Constant):
            return failure_models.Constant(model.share * whole.p)
    if not isinstance(model, ExpressionModel):
        is_constant = isinstance(model, failure_models.Constant)
        return model if is_constant else None
    expression: Expression = model.expression
    names = owner.definitions.by_name
    while isinstance(expression, Reference):
        expression = names[expression.name]
    if not depends_on_mission_time((expression,), names):
        return failure_models.Constant(model.probability(0.0).p)
    if isinstance(expression, Exponential | Weibull | Glm):
        *figures, time = expression.arguments
        while isinstance(time, Reference):
            time = names[time.name]
        if isinstance(time, MissionTime) and not depends_on_mission_time(figures, names):
            return expression.model([evaluation.of(figure) for figure in figures])
    return None
