"""What if a figure of a logic model were another, and the uncertainty of its tops."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.strata import LatinHypercube
from tracerisk.prm.other_models.expressions import (
    Evaluation,
    Expression,
    ExpressionModel,
    Number,
    Reference,
    references,
)
from tracerisk.prm.other_models.expressions.deviates import Deviate
from tracerisk.prm.other_models.expressions.evaluation import nodes
from tracerisk.prm.other_models.expressions.sampling import Sampling
from tracerisk.prm.other_models.logic.common_cause import ShareOf
from tracerisk.prm.other_models.logic.model import LogicModel
from tracerisk.prm.questions.sobol import first_order_shares
from tracerisk.prm.questions.uncertainty import SAMPLES, InputShare, Uncertainty, percentiles_of
from tracerisk.prm.trees.events import FailureModel, HouseEvent

if TYPE_CHECKING:
    from tracerisk.prm.other_models.expressions.node import Array


def value_of(model: LogicModel, name: str, mission_time_h: float) -> float:
    """Return the figure of a parameter, event, house event or common cause group.

    Raises ModelError when there is none of that name, or it has no figure.
    """
    houses = {house.name: house.house.state for house in model.houses}
    expression = _settable(model).get(name)
    if expression is not None:
        return Evaluation(model.definitions.by_name, mission_time_h).of(expression)
    if name in houses:
        return float(houses[name])
    return math.nan


def with_values(model: LogicModel, values: Mapping[str, float]) -> LogicModel:
    """Return the model with parameters, events, house events (0 or 1) or groups set.

    A name that a parameter has means the parameter, else the event of that name.
    Raises ModelError when there is none of that name, when the event is a member of a common
    cause group, or when a house event is set to another number.
    """
    table = dict(values)
    known = _settable(model)
    for name in values:
        if name not in known:
            _fail(model, name, known)
    parameters = []
    for parameter in model.parameters:
        value = table.pop(parameter.name, None)
        parameters.append(
            parameter if value is None else replace(parameter, expression=Number(value))
        )
    groups = []
    for group in model.groups:
        value = table.pop(group.name, None)
        groups.append(group if value is None else replace(group, distribution=Number(value)))
    events = []
    for event in model.events:
        value = table.pop(event.name, None)
        if value is not None and not 0.0 <= value <= 1.0:
            raise ModelError(f"event '{event.name}': {value!r} is not a probability; give 0 to 1")
        events.append(event if value is None else replace(event, expression=Number(value)))
    houses = []
    for house in model.houses:
        value = table.pop(house.name, None)
        if value not in (None, 0.0, 1.0):
            raise ModelError(f"house event '{house.name}': {value!r}; set it to 0 or 1")
        state = house.house.state if value is None else bool(value)
        houses.append(replace(house, house=HouseEvent(house.name, state)))
    return replace(
        model,
        parameters=tuple(parameters),
        groups=tuple(groups),
        events=tuple(events),
        houses=tuple(houses),
    )


def propagate(
    model: LogicModel,
    top: str,
    mission_time_h: float,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    note: Callable[[str], None] = lambda text: None,  # noqa: ARG005
) -> Uncertainty:
    """Draw the deviates of the model and return the spread of a top's probability.

    Inputs are the parameters and events whose own expression holds a deviate. Probabilities above
    one are taken as one; where they are no input's own, `note` is called with a note of it.
    Raises ModelError when nothing is uncertain, `samples` is below 2, or a factor of a common
    cause group is drawn: the events of a group follow from the point values of its factors.
    """
    if samples < 2:
        raise ModelError(f"{samples} samples; give at least 2")
    _check_factors(model)
    tree = model.fault_tree(top, mission_time_h=mission_time_h)
    point_values = tree.values_at(mission_time_h)
    point = tree.probability(point_values).p
    names = model.definitions.by_name
    sampling = Sampling(names, mission_time_h, LatinHypercube(samples, seed))
    drawn: dict[str, Array] = {}
    own: dict[str, Array] = {}
    cut: dict[str, int] = {}
    shared: set[str] = set()
    for event in tree.events:
        if event.parameter in drawn or event.model is None:
            continue
        expression = _expression(event.model)
        values = _sampled(event.model, sampling, event.parameter)
        cut[event.parameter] = int((values > 1.0).sum())
        drawn[event.parameter] = np.minimum(values, 1.0)
        if isinstance(expression, Reference) and expression.name == event.parameter:
            shared.add(event.parameter)
        elif expression is not None and _holds_deviate(expression):
            own[event.parameter] = drawn[event.parameter]
    inputs = {
        name: drawn[name] if name in shared else values
        for name, values in sampling.sampled.items()
        if isinstance(names.get(name), Expression) and _holds_deviate(names[name])
    } | own
    if not inputs:
        raise ModelError(
            f"nothing below '{top}' is uncertain; use deviates for parameters or events in the "
            "model"
        )
    for name, count in cut.items():
        if count and name not in own and name not in shared:
            note(f"{name}: {count} of {samples} samples above 1 were set to 1")
    results: Array = tree.probabilities(drawn)[:, 0]
    shares = first_order_shares(np.column_stack(list(inputs.values())), results)
    evaluation = Evaluation(names, mission_time_h)
    rows = [
        InputShare(
            name=name,
            value=point_values[name] if name in own else evaluation.of(Reference(name)),
            percentiles=percentiles_of(values),
            share=float(share),
            cut=cut[name] if name in own or name in shared else 0,
        )
        for (name, values), share in zip(inputs.items(), shares, strict=True)
    ]
    rows.sort(key=lambda row: (-row.share, row.name))
    return Uncertainty.of_draws(results, seed=seed, point=point, inputs=tuple(rows))


def _sampled(model: FailureModel, sampling: Sampling, owner: str) -> Array:
    """Return the draws of a failure model; those of one owner are drawn once."""
    if isinstance(model, ShareOf):
        whole = _sampled(model.model, sampling, model.parameter)
        return model.share * np.minimum(whole, 1.0)
    if isinstance(model, ExpressionModel):
        return sampling.of(model.expression, owner)
    raise ModelError(f"event '{owner}': {type(model).__name__} cannot be sampled")


def _expression(model: FailureModel) -> Expression | None:
    if isinstance(model, ShareOf):
        return _expression(model.model)
    return model.expression if isinstance(model, ExpressionModel) else None


def _holds_deviate(expression: Expression) -> bool:
    """Return whether a deviate stands in the expression itself, not behind a name."""
    return any(isinstance(node, Deviate) for node in nodes(expression))


def _check_factors(model: LogicModel) -> None:
    names = model.definitions.by_name
    for group in model.groups:
        waiting = [factor for _, factor in group.factors]
        seen: set[str] = set()
        while waiting:
            expression = waiting.pop()
            if _holds_deviate(expression):
                raise ModelError(
                    f"common cause group '{group.name}': a factor is a deviate, which cannot be "
                    "sampled; give it a number, or solve without --uncertainty"
                )
            more = [name for name in references(expression) if name not in seen]
            seen.update(more)
            waiting.extend(names[name] for name in more if name in names)


def _settable(model: LogicModel) -> dict[str, Expression | None]:
    """Return what can be set, by name, with its expression where it has one."""
    members = {member for group in model.groups for member in group.members}
    settable: dict[str, Expression | None] = dict.fromkeys(house.name for house in model.houses)
    settable |= {
        event.name: event.expression for event in model.events if event.name not in members
    }
    settable |= {group.name: group.distribution for group in model.groups}
    settable |= {parameter.name: parameter.expression for parameter in model.parameters}
    return settable


def _fail(model: LogicModel, name: str, known: Mapping[str, object]) -> None:
    for group in model.groups:
        if name in group.members:
            raise ModelError(
                f"event '{name}' is a member of the common cause group '{group.name}'; "
                "set the group"
            )
    raise ModelError(f"there is no parameter, event or house event '{name}'; {one_of(known, name)}")
