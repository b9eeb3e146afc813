"""One fault tree out of a model of many: what stands below a top, with common causes expanded."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.other_models.event_trees.forest import Forest
from tracerisk.prm.other_models.expressions import Evaluation, ExpressionModel, Reference
from tracerisk.prm.other_models.logic.checks import ALWAYS, NEVER
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.other_models.logic.common_cause import CommonCauseGroup
    from tracerisk.prm.other_models.logic.mission_parts import GroupDefinition
    from tracerisk.prm.other_models.logic.model import LogicModel


def tree_below(
    model: LogicModel, top: str, *, common_cause: bool, mission_time_h: float
) -> FaultTree:
    """Return the tree below a gate or event; see `LogicModel.fault_tree`."""
    with collection_paused():
        result = forest(model, common_cause=common_cause, mission_time_h=mission_time_h)
        if top not in result:
            raise ModelError(f"there is no top '{top}'; {one_of(model.tops, top)}")
        gates = dict(result.gates)
        if model.substitutions:
            top = _substituted(model, top, gates)
        below: dict[str, None] = {}
        stack = [top]
        while stack:
            name = stack.pop()
            if name not in below:
                below[name] = None
                gate = gates.get(name)
                if gate is not None:
                    stack.extend(reversed(gate.inputs))
        return FaultTree(
            top,
            tuple(gates[name] for name in below if name in gates),
            tuple(result.events[name] for name in below if name in result.events),
            tuple(result.houses[name] for name in below if name in result.houses),
        )


def forest(model: LogicModel, *, common_cause: bool = True, mission_time_h: float = 0.0) -> Forest:
    """Return all gates and events of the model, common cause groups expanded by default.

    The factors of a group may depend on the mission time, [h].
    Raises ModelError when a factor is missing or cannot be evaluated.
    """
    gates = dict(model.gates_by_name)
    events = {event.name: event for event in basic_events(model)}
    houses = {house.name: house.house for house in model.houses}
    houses |= {ALWAYS: HouseEvent(ALWAYS, True), NEVER: HouseEvent(NEVER, False)}
    if common_cause and model.groups:
        _expand(model, gates, events, mission_time_h)
    return Forest(gates, events, houses)


def basic_events(model: LogicModel) -> Iterable[BasicEvent]:
    """Yield the basic events with the models of their figures.

    Members of a common cause group share the parameter of the group's name, events whose figure is
    a parameter that one; all others have their own.
    """
    definitions = model.definitions
    own = {event.name for event in model.events if not isinstance(event.expression, Reference)}
    members = {member: group for group in model.groups for member in group.members}
    for event in model.events:
        group = members.get(event.name)
        expression = event.expression if group is None else group.distribution
        location = partial(model.locations.get, ("basic event", event.name))
        figure = None if expression is None else ExpressionModel(expression, definitions, location)
        parameter = event.name
        if group is not None:
            parameter = _distinct(group.name, own)
        elif isinstance(expression, Reference):
            parameter = _distinct(expression.name, own)
        yield BasicEvent(event.name, parameter, figure)


def _distinct(name: str, own: set[str]) -> str:
    return f"{name} (shared)" if name in own else name


def common_cause_groups(
    groups: Iterable[GroupDefinition], values: Evaluation
) -> tuple[CommonCauseGroup, ...]:
    """Return the groups with the values of their factors.

    Raises ModelError when levels are missing or factors do not fit the law.
    """
    from tracerisk.prm.other_models.logic.common_cause import CommonCauseGroup

    cause_groups = []
    for group in groups:
        first = group.factors[0][0] if group.factors else 1
        for place, (level, _) in enumerate(group.factors):
            if level != first + place:
                raise ModelError(
                    f"common cause group '{group.name}': the factor of level {first + place} is "
                    "missing; give one for each level"
                )
        factors = tuple(values.of(factor) for _, factor in group.factors)
        cause_groups.append(CommonCauseGroup(group.name, group.members, group.law, factors))
    return tuple(cause_groups)


def _expand(
    model: LogicModel,
    gates: dict[str, Gate],
    events: dict[str, BasicEvent],
    mission_time_h: float,
) -> None:
    """Replace the members of all groups, under whatever tops they stand."""
    from tracerisk.prm.other_models.logic.common_cause import expand_common_cause

    values = Evaluation(model.definitions.by_name, mission_time_h)
    groups = common_cause_groups(model.groups, values)
    members = {member: None for group in groups for member in group.members}
    everything = Gate("#members", GateKind.OR, tuple(members))
    tree = FaultTree(everything.name, (everything,), tuple(events[name] for name in members))
    expanded = expand_common_cause(tree, groups).tree
    for name in members:
        del events[name]
    gates |= {gate.name: gate for gate in expanded.gates if gate.name != everything.name}
    events |= {event.name: event for event in expanded.events}


def _substituted(model: LogicModel, top: str, gates: dict[str, Gate]) -> str:
    """Add the implications that declarative substitutions are, and return the new top.

    Source: the Open-PSA Model Exchange Format as SCRAM 0.16 reads it, substitutions.
    """
    implications = []
    for substitution in model.substitutions:
        if substitution.sources:
            raise ModelError(
                f"substitution '{substitution.name}' replaces events in cut sets, so the exact "
                "probability is undefined; remove its sources, or the substitution",
                model.locations.get(("substitution", substitution.name)),
            )
        name = f"#{substitution.name}"
        target = _target(substitution.target)
        gates[name] = Gate(name, GateKind.IMPLY, (substitution.hypothesis, target))
        implications.append(name)
    joined = f"#{top}"
    gates[joined] = Gate(joined, GateKind.AND, (top, *implications))
    return joined


def _target(target: str | bool) -> str:
    return target if isinstance(target, str) else ALWAYS if target else NEVER
