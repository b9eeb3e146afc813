"""What a file of Open-PSA or OpenPRA holds: gates and events under many tops, and their figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.other_models.expressions import Definitions, Expression
from tracerisk.prm.other_models.logic.checks import ALWAYS as ALWAYS
from tracerisk.prm.other_models.logic.checks import NEVER as NEVER
from tracerisk.prm.other_models.logic.checks import ElementError as ElementError
from tracerisk.prm.other_models.logic.checks import check_model
from tracerisk.prm.other_models.logic.trees import tree_below
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    from tracerisk.prm.other_models.event_trees.elements import InitiatingEvent
    from tracerisk.prm.other_models.logic.mission_parts import (
        Alignment,
        EventTreeDefinition,
        GroupDefinition,
        Substitution,
    )
else:
    Protocol = object


@dataclass(frozen=True, slots=True)
class Attribute:
    """A remark of a tool on an element, with no meaning for the model."""

    name: str
    """Name of the remark."""
    value: str
    """Text of the remark."""
    type: str = ""
    """Type that the tool gives the value; "" where none."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where an element is defined, and what is said of it."""

    home: str = ""
    """Path of its fault tree or component, such as `pumps.train`; "" for the model."""
    private: bool = False
    """Whether only elements of its home see its short name; its full name begins with `home`."""
    label: str = ""
    """Text that describes the element; "" for none."""
    attributes: tuple[Attribute, ...] = ()
    """Remarks of tools on the element, in order."""


NOWHERE = Place()


@dataclass(frozen=True, slots=True)
class GateDefinition:
    """A gate as a file defines it."""

    gate: Gate
    """The gate, with the full names of its inputs."""
    place: Place = NOWHERE
    """Where it is defined."""
    nested: bool = False
    """Whether it is written inside the formula of the only gate that it feeds."""

    @property
    def name(self) -> str:
        """The gate's name."""
        return self.gate.name


@dataclass(frozen=True, slots=True)
class EventDefinition:
    """A basic event as a file defines it."""

    name: str
    """Full name, unique among gates and events."""
    expression: Expression | None = None
    """Expression of its probability; `None` where none is given."""
    place: Place = NOWHERE
    """Where it is defined."""


@dataclass(frozen=True, slots=True)
class HouseDefinition:
    """A house event as a file defines it."""

    house: HouseEvent
    """The house event."""
    place: Place = NOWHERE
    """Where it is defined."""

    @property
    def name(self) -> str:
        """The house event's name."""
        return self.house.name


@dataclass(frozen=True, slots=True)
class ParameterDefinition:
    """A parameter, to which expressions refer by its name."""

    name: str
    """Full name, unique among parameters."""
    expression: Expression
    """Expression of its value."""
    unit: str = ""
    """Unit as a remark, such as `hours-1`; "" for none."""
    place: Place = NOWHERE
    """Where it is defined."""


@dataclass(frozen=True, slots=True)
class Container:
    """A fault tree of the file, or a component in one."""

    path: str
    """Full name."""
    private: bool = False
    """Whether its elements are private unless they say otherwise."""
    label: str = ""
    """Text that describes it; "" for none."""
    attributes: tuple[Attribute, ...] = ()
    """Remarks of tools on it, in order."""


@dataclass(frozen=True, slots=True)
class LogicModel:
    """Gates and events by name, all that they are computed from, and event trees over them.

    Gates, basic events and house events share one space of names, parameters have another.

    Raises ElementError when a name is used twice or unknown, a gate stands above itself or has
    inputs that do not fit its kind, or a parameter is defined by itself.
    """

    name: str = ""
    """Name of the model; "" for none."""
    gates: tuple[GateDefinition, ...] = ()
    """Gates in the order of the file, nested ones included."""
    events: tuple[EventDefinition, ...] = ()
    """Basic events."""
    houses: tuple[HouseDefinition, ...] = ()
    """House events."""
    parameters: tuple[ParameterDefinition, ...] = ()
    """Parameters of expressions."""
    groups: tuple[GroupDefinition, ...] = ()
    """Common cause groups."""
    event_trees: tuple[EventTreeDefinition, ...] = ()
    """Event trees over the gates and events."""
    initiating_events: tuple[InitiatingEvent, ...] = ()
    """Initiating events that begin no event tree."""
    alignments: tuple[Alignment, ...] = ()
    """Divisions of the mission into phases."""
    substitutions: tuple[Substitution, ...] = ()
    """Rules on what happens together."""
    containers: tuple[Container, ...] = ()
    """Fault trees and components of the file."""
    label: str = ""
    """Text that describes the model; "" for none."""
    attributes: tuple[Attribute, ...] = ()
    """Remarks of tools on the model, in order."""
    findings: tuple[str, ...] = field(default=(), compare=False)
    """Remarks of the reader, one sentence each."""
    locations: Mapping[tuple[str, str], Location] = field(
        default_factory=dict, compare=False, repr=False
    )
    """Place in the file by (kind, name) of an element; empty where unknown."""
    gates_by_name: Mapping[str, Gate] = field(init=False, compare=False, repr=False)
    """The gates by full name."""
    definitions: Definitions = field(init=False, compare=False, repr=False)
    """The parameters by name, as expressions see them."""

    def __post_init__(self) -> None:
        gates = {gate.gate.name: gate.gate for gate in self.gates}
        object.__setattr__(self, "gates_by_name", gates)
        check_model(self)
        entries = tuple((parameter.name, parameter.expression) for parameter in self.parameters)
        object.__setattr__(self, "definitions", Definitions(entries))

    @property
    def tops(self) -> tuple[str, ...]:
        """The gates that feed no other gate of their own fault tree, in their order."""
        homes = {gate.name: _tree_of(gate.place.home) for gate in self.gates}
        fed = {
            name
            for gate in self.gates
            for name in gate.gate.inputs
            if name in homes and homes[name] == homes[gate.name]
        }
        hypotheses = {substitution.hypothesis for substitution in self.substitutions}
        return tuple(
            gate.name
            for gate in self.gates
            if gate.name not in fed and not gate.nested and gate.name not in hypotheses
        )

    def fault_tree(
        self, top: str, *, common_cause: bool = True, mission_time_h: float = 0.0
    ) -> FaultTree:
        """Return the tree below a gate or event, its events with the models of their figures.

        Members of common cause groups become the events that hit them unless `common_cause` is
        off; the factors of a group may depend on the mission time, [h].
        Raises ModelError when there is no such gate or event, or a substitution is not exact.
        """
        return tree_below(self, top, common_cause=common_cause, mission_time_h=mission_time_h)

    def in_phase(self, alignment: str, phase: str) -> LogicModel:
        """Return the model with its house events as a phase of an alignment sets them.

        Raises ModelError when there is no such alignment or phase.
        """
        alignments = {item.name: item for item in self.alignments}
        if alignment not in alignments:
            raise ModelError(
                f"there is no alignment '{alignment}'; {one_of(alignments, alignment)}"
            )
        phases = {item.name: item for item in alignments[alignment].phases}
        if phase not in phases:
            raise ModelError(
                f"alignment '{alignment}' has no phase '{phase}'; {one_of(phases, phase)}"
            )
        states = dict(phases[phase].houses)
        houses = tuple(
            replace(house, house=HouseEvent(house.name, states.get(house.name, house.house.state)))
            for house in self.houses
        )
        return replace(self, houses=houses)


class Placed(Protocol):
    """What stands in a file."""

    @property
    def location(self) -> Location:
        """Where it stands."""


class Locations(Mapping[tuple[str, str], Location]):
    """Where elements stand, by kind and name; each is looked up when it is asked for."""

    def __init__(self, elements: Mapping[tuple[str, str], Placed]) -> None:
        self._elements = elements

    def __getitem__(self, key: tuple[str, str]) -> Location:
        return self._elements[key].location

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self._elements)

    def __len__(self) -> int:
        return len(self._elements)


def _tree_of(home: str) -> str:
    return home.partition(".")[0]
