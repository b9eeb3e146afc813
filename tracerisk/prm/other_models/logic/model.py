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
    from tracerisk.prm.other_models.event_trees.event_tree import EventTree
    from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw
else:
    Protocol = object


@dataclass(frozen=True, slots=True)
class Attribute:
    """A remark of a tool on an element, with no meaning for the model."""

    name: str
    value: str
    type: str = ""


@dataclass(frozen=True, slots=True)
class Place:
    """Where an element is defined, and what is said of it.

    `home` is the path of its fault tree or component, `pumps.train`, or empty for the model; the
    full name of a `private` element begins with it, and only those of its home see its short name.
    """

    home: str = ""
    private: bool = False
    label: str = ""
    attributes: tuple[Attribute, ...] = ()


NOWHERE = Place()


@dataclass(frozen=True, slots=True)
class GateDefinition:
    """A gate; a `nested` one is written inside the formula of the only gate that it feeds."""

    gate: Gate
    place: Place = NOWHERE
    nested: bool = False

    @property
    def name(self) -> str:
        """The gate's name."""
        return self.gate.name


@dataclass(frozen=True, slots=True)
class EventDefinition:
    """A basic event and the expression of its probability, if one is given."""

    name: str
    expression: Expression | None = None
    place: Place = NOWHERE


@dataclass(frozen=True, slots=True)
class HouseDefinition:
    """A house event."""

    house: HouseEvent
    place: Place = NOWHERE

    @property
    def name(self) -> str:
        """The house event's name."""
        return self.house.name


@dataclass(frozen=True, slots=True)
class ParameterDefinition:
    """A parameter, to which expressions refer by its name; `unit` is a remark: `hours-1`."""

    name: str
    expression: Expression
    unit: str = ""
    place: Place = NOWHERE


@dataclass(frozen=True, slots=True)
class GroupDefinition:
    """A common cause group whose figures are expressions; each factor with its level."""

    name: str
    law: CommonCauseLaw
    members: tuple[str, ...]
    distribution: Expression
    factors: tuple[tuple[int, Expression], ...]
    place: Place = NOWHERE


@dataclass(frozen=True, slots=True)
class EventTreeDefinition:
    """An event tree; `notes` are labels and attributes of its parts, by kind and name."""

    tree: EventTree
    place: Place = NOWHERE
    notes: tuple[tuple[str, str, Place], ...] = ()

    @property
    def name(self) -> str:
        """The event tree's name."""
        return self.tree.name


@dataclass(frozen=True, slots=True)
class Phase:
    """A share of the mission time with states of house events."""

    name: str
    fraction: float
    houses: tuple[tuple[str, bool], ...] = ()
    place: Place = NOWHERE


@dataclass(frozen=True, slots=True)
class Alignment:
    """The phases of a mission."""

    name: str
    phases: tuple[Phase, ...]
    place: Place = NOWHERE


@dataclass(frozen=True, slots=True)
class Substitution:
    """Where the gate `hypothesis` happens, so does `target` (False: such courses are left out).

    With `sources` it is a replacement of events in cut sets, which has no exact probability.
    """

    name: str
    hypothesis: str
    target: str | bool
    sources: tuple[str, ...] = ()
    type: str = ""
    place: Place = NOWHERE


@dataclass(frozen=True, slots=True)
class Container:
    """A fault tree of the file, or a component in one; `path` is its full name."""

    path: str
    private: bool = False
    label: str = ""
    attributes: tuple[Attribute, ...] = ()


@dataclass(frozen=True, slots=True)
class LogicModel:
    """Gates and events by name, all that they are computed from, and event trees over them.

    Gates, basic events and house events share one space of names, parameters have another.
    `findings` are remarks of whoever read the model, `locations` where each element stands.
    Raises ElementError when a name is used twice or unknown, a gate stands above itself or has
    inputs that do not fit its kind, or a parameter is defined by itself.
    """

    name: str = ""
    gates: tuple[GateDefinition, ...] = ()
    events: tuple[EventDefinition, ...] = ()
    houses: tuple[HouseDefinition, ...] = ()
    parameters: tuple[ParameterDefinition, ...] = ()
    groups: tuple[GroupDefinition, ...] = ()
    event_trees: tuple[EventTreeDefinition, ...] = ()
    initiating_events: tuple[InitiatingEvent, ...] = ()
    alignments: tuple[Alignment, ...] = ()
    substitutions: tuple[Substitution, ...] = ()
    containers: tuple[Container, ...] = ()
    label: str = ""
    attributes: tuple[Attribute, ...] = ()
    findings: tuple[str, ...] = field(default=(), compare=False)
    locations: Mapping[tuple[str, str], Location] = field(
        default_factory=dict, compare=False, repr=False
    )
    gates_by_name: Mapping[str, Gate] = field(init=False, compare=False, repr=False)
    definitions: Definitions = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        gates = {each.gate.name: each.gate for each in self.gates}
        object.__setattr__(self, "gates_by_name", gates)
        check_model(self)
        entries = tuple((each.name, each.expression) for each in self.parameters)
        object.__setattr__(self, "definitions", Definitions(entries))

    @property
    def tops(self) -> tuple[str, ...]:
        """The gates that feed no other gate of their own fault tree, in their order."""
        homes = {each.name: _tree_of(each.place.home) for each in self.gates}
        fed = {
            name
            for each in self.gates
            for name in each.gate.inputs
            if name in homes and homes[name] == homes[each.name]
        }
        hypotheses = {each.hypothesis for each in self.substitutions}
        return tuple(
            each.name
            for each in self.gates
            if each.name not in fed and not each.nested and each.name not in hypotheses
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
        alignments = {each.name: each for each in self.alignments}
        if alignment not in alignments:
            raise ModelError(
                f"there is no alignment '{alignment}'; {one_of(alignments, alignment)}"
            )
        phases = {each.name: each for each in alignments[alignment].phases}
        if phase not in phases:
            raise ModelError(
                f"alignment '{alignment}' has no phase '{phase}'; {one_of(phases, phase)}"
            )
        states = dict(phases[phase].houses)
        houses = tuple(
            replace(each, house=HouseEvent(each.name, states.get(each.name, each.house.state)))
            for each in self.houses
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
