"""What the leaves of a function's fault tree are called, and their figures: the robot's own units.

A block has one figure for all units of a component. Where a run is known, each unit has its own,
and what they make together is the block's: then a leaf shows it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tracerisk.adder.figures.instances import ComponentInstances
from tracerisk.common.function_ref import FunctionRef
from tracerisk.prm.hybrid.elements import FunctionState
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.report.html.report_input import ReportInput

_AGREES = 6e-4
"""How far what the units make may be from the model's figure, which has the four digits of the
block."""


@dataclass(frozen=True, slots=True)
class Leaves:
    """How the basic events of a tree are shown."""

    labels: Mapping[str, str] = field(default_factory=dict)
    """The robot's name of a unit, by the name of its event in the model."""
    figures: Mapping[str, float] = field(default_factory=dict)
    """The unit's own failure probability in a visit, where it has one."""
    notes: tuple[str, ...] = ()
    """Which components have names of units but the one figure of the block, and why."""

    def label(self, name: str) -> str:
        """Return what a gate or an event is called."""
        return self.labels.get(name, name)


def leaves_of(report: ReportInput, state: FunctionState) -> Leaves:
    """Return the units behind the events of a state's tree; none where no run is known."""
    if report.figures is None:
        return Leaves()
    refs = [ref for ref, name in report.names.items() if name == state.name]
    labels: dict[str, str] = {}
    figures: dict[str, float] = {}
    notes = []
    for component in report.figures.instances:
        name = component.component.name
        units = [unit for ref in refs for unit in _units(component, ref)]
        events = [
            basic_event.name
            for basic_event in state.tree.events
            if basic_event.name.startswith(f"{name}[")
        ]
        events = [text for text in events if text[len(name) + 1 : -1].isdigit()]
        if not units or len(units) != len(events):
            continue
        labels |= {event: label for event, (label, _) in zip(events, units, strict=True)}
        own = {event: p for event, (_, p) in zip(events, units, strict=True)}
        if _agree(state, name, own):
            figures |= own
        else:
            notes.append(
                f"The units of {name} are shown with the one figure that its block has for each; "
                "their own do not make the function's."
            )
    return Leaves(labels, figures, tuple(notes))


def _units(component: ComponentInstances, ref: FunctionRef) -> Sequence[tuple[str, float]]:
    """Return the units in one function, each with its probability in a visit."""
    return [
        (
            instance.element if instance.units == 1 else f"{instance.element} ({number})",
            instance.per_visit[ref],
        )
        for instance in component.instances
        if ref in instance.per_visit
        for number in range(1, instance.units + 1)
    ]


def _agree(state: FunctionState, component: str, own: Mapping[str, float]) -> bool:
    """Return whether units with their own figures fail a component as the model has it."""
    gates = {gate.name: gate for gate in state.tree.gates}
    if component not in gates:
        return False
    below = [component]
    for name in below:
        below += [text for text in gates[name].inputs if text not in below] if name in gates else []
    events = [event for event in state.tree.events if event.name in below]
    tree = FaultTree(
        component,
        tuple(gate for gate in state.tree.gates if gate.name in below),
        tuple(BasicEvent(event.name) for event in events),
        tuple(house for house in state.tree.houses if house.name in below),
    )
    model = {event.name: state.probabilities[event.parameter] for event in events}
    one, other = (tree.probability(values).p for values in (model, {**model, **own}))
    return math.isclose(one, other, rel_tol=_AGREES)
