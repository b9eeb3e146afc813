"""Common causes of OpenPRA as gates and events, and back.

The engine as of 2026-01-09 refuses each group: it sets the figure before the members, and then
takes no member. So the groups are written out, and stand beside the model for our reader.
"""

from __future__ import annotations

from dataclasses import replace

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.event_trees.forest import Forest
from tracerisk.prm.other_models.expressions import Expression, Number
from tracerisk.prm.other_models.logic.mission_parts import GroupDefinition
from tracerisk.prm.other_models.logic.model import EventDefinition, GateDefinition, LogicModel
from tracerisk.prm.other_models.logic.trees import forest
from tracerisk.prm.trees.gates import Gate


def written_out(model: LogicModel) -> LogicModel:
    """Return the model with the events that hit the members of its groups; figures are numbers."""
    below = forest(model)
    users = {name: gate.place for gate in reversed(model.gates) for name in gate.gate.inputs}
    members = {member: group for group in model.groups for member in group.members}
    gates = [GateDefinition(below.gates[name], users[name]) for name in members if name in users]
    hits = dict.fromkeys(hit for gate in gates for hit in gate.gate.inputs)
    lone = {name: group for name, group in members.items() if name not in users}
    events = [
        replace(event, expression=lone[event.name].distribution) if event.name in lone else event
        for event in model.events
        if event.name in lone or event.name not in members
    ]
    events += [EventDefinition(hit, Number(_figure(below, hit))) for hit in hits]
    return replace(model, groups=(), gates=(*model.gates, *gates), events=tuple(events))


def restored(model: LogicModel, groups: tuple[GroupDefinition, ...]) -> LogicModel | None:
    """Return the model with its groups; `None` where what is written out says something else."""
    members = {member for group in groups for member in group.members}
    gates = {gate.name: gate for gate in model.gates if gate.name in members}
    hits = {hit for gate in gates.values() for hit in gate.gate.inputs}
    events = [event for event in model.events if event.name not in hits | members]
    # The figure of a member is that of its group, which is in no fault tree.
    events += [EventDefinition(name) for group in groups for name in group.members]
    try:
        with_groups = replace(
            model,
            groups=groups,
            gates=tuple(gate for gate in model.gates if gate.name not in gates),
            events=tuple(events),
        )
        again = written_out(with_groups)
    except ModelError:
        return None
    return with_groups if _content(again) == _content(model) else None


def _figure(below: Forest, hit: str) -> float:
    figure = below.events[hit].model
    assert figure is not None
    return figure.probability(0.0).p


def _content(model: LogicModel) -> tuple[dict[str, Gate], dict[str, Expression | None]]:
    return dict(model.gates_by_name), {event.name: event.expression for event in model.events}
