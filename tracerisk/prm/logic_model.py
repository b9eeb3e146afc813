"""What a file of Open-PSA or OpenPRA holds: gates and events under many tops, and their figures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.expressions import Definitions, Expression, references
from tracerisk.prm.fault_tree import FaultTree, HouseEvent
from tracerisk.prm.gates import Gate, check_gate

if TYPE_CHECKING:
    from tracerisk.prm.common_cause import CommonCauseLaw
    from tracerisk.prm.event_tree import EventTree, InitiatingEvent

ALWAYS, NEVER = "#true", "#false"
"""The names of the two constants, as inputs of gates; they need no definition."""


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
        _check_names(self)
        named = {ALWAYS, NEVER, *gates}
        named.update(each.name for each in self.events)
        named.update(each.name for each in self.houses)
        for gate in gates.values():
            for name in gate.inputs:
                if name not in named:
                    raise ElementError(
                        "gate",
                        gate.name,
                        f"gate '{gate.name}': input '{name}' is no gate or event; "
                        f"{_near(named, name)}",
                    )
            try:
                check_gate(gate)
            except ModelError as error:
                raise ElementError("gate", gate.name, error.message) from error
        _check_cycles("gate", {name: gate.inputs for name, gate in gates.items()})
        uses = {each.name: references(each.expression) for each in self.parameters}
        _check_cycles("parameter", uses)
        _check_references(self, uses)
        _check_groups(self)
        _check_alignments(self)
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
        from tracerisk.prm.logic_trees import tree_below

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
        ...


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


class ElementError(ModelError):
    """An element of a model is malformed; `kind` and `element` say which."""

    def __init__(self, kind: str, element: str, message: str) -> None:
        super().__init__(message)
        self.kind = kind
        self.element = element


def _tree_of(home: str) -> str:
    return home.partition(".")[0]


def _near(names: Iterable[str], found: str) -> str:
    """Return the nearest name, or all where they are few: a model may have a million."""
    listed = [name for name in names if not name.startswith("#")]
    if len(listed) <= 30:
        return one_of(listed, found)
    if len(listed) > 20_000:
        return "define it"
    from difflib import get_close_matches

    near = get_close_matches(found, listed, n=1)
    return f"did you mean '{near[0]}'?" if near else "define it"


def _check_names(model: LogicModel) -> None:
    spaces: tuple[tuple[tuple[str, Iterable[str]], ...], ...] = (
        (
            ("gate", (each.gate.name for each in model.gates)),
            ("basic event", (each.name for each in model.events)),
            ("house event", (each.house.name for each in model.houses)),
        ),
        (("parameter", (each.name for each in model.parameters)),),
        (("common cause group", (each.name for each in model.groups)),),
        (("event tree", (each.tree.name for each in model.event_trees)),),
        (("alignment", (each.name for each in model.alignments)),),
        (("substitution", (each.name for each in model.substitutions)),),
        (("fault tree", (each.path for each in model.containers)),),
    )
    for space in spaces:
        kinds: dict[str, str] = {}
        for kind, names in space:
            for name in names:
                if name in kinds:
                    raise ElementError(
                        kind, name, f"'{name}' names a {kind} and a {kinds[name]}; rename one"
                    )
                if not name or not name.isprintable() or name in (ALWAYS, NEVER):
                    raise ElementError(
                        kind, name, f"{name!r} names a {kind}; it needs other, printable characters"
                    )
                kinds[name] = kind


def _check_cycles(kind: str, below: Mapping[str, tuple[str, ...]]) -> None:
    """Check that nothing leads to itself; iterative, for any depth."""
    done: set[str] = set()
    for start in below:
        if start in done:
            continue
        path: dict[str, None] = {}
        stack = [(start, False)]
        while stack:
            name, left = stack.pop()
            if left:
                del path[name]
                done.add(name)
            elif name in path:
                names = [*path, name]
                cycle = " -> ".join(names[names.index(name) :])
                raise ElementError(
                    kind, name, f"{kind} '{name}' stands above itself ({cycle}); break the cycle"
                )
            elif name not in done and name in below:
                path[name] = None
                stack.append((name, True))
                stack.extend([(each, False) for each in reversed(below[name])])


def _check_references(model: LogicModel, uses: Mapping[str, tuple[str, ...]]) -> None:
    for kind, name, found in (
        *(("parameter", name, found) for name, found in uses.items()),
        *(
            ("basic event", each.name, references(each.expression))
            for each in model.events
            if each.expression is not None and each.expression.arguments
        ),
    ):
        for used in found:
            if used not in uses:
                raise ElementError(
                    kind, name, f"{kind} '{name}': no parameter '{used}'; {_near(uses, used)}"
                )


def _check_groups(model: LogicModel) -> None:
    if not model.groups:
        return
    events = {each.name for each in model.events}
    owners: dict[str, str] = {}
    for group in model.groups:
        where = f"common cause group '{group.name}'"
        for member in group.members:
            problem = ""
            if member not in events:
                problem = f"member '{member}' is no basic event; {_near(events, member)}"
            elif member in owners:
                problem = f"member '{member}' is one of '{owners[member]}' too; take one out"
            if problem:
                raise ElementError("common cause group", group.name, f"{where}: {problem}")
            owners[member] = group.name


def _check_alignments(model: LogicModel) -> None:
    houses = {each.house.name for each in model.houses}
    for alignment in model.alignments:
        for phase in alignment.phases:
            for house, _ in phase.houses:
                if house not in houses:
                    raise ElementError(
                        "alignment",
                        alignment.name,
                        f"alignment '{alignment.name}': phase '{phase.name}' sets '{house}', "
                        f"which is no house event; {_near(houses, house)}",
                    )
