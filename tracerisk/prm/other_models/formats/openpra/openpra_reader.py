"""The OpenPRA engine's JSON as a logic model."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.errors import Location, ModelError
from tracerisk.prm.formats.element import Element, read_document
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.other_models.expressions import Expression, Number
from tracerisk.prm.other_models.formats.openpra.common_causes import restored
from tracerisk.prm.other_models.formats.openpra.engine_names import restore_names
from tracerisk.prm.other_models.formats.openpra.event_trees import read_event_tree
from tracerisk.prm.other_models.formats.openpra.logic import read_logic
from tracerisk.prm.other_models.logic.checks import suggestion
from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw
from tracerisk.prm.other_models.logic.mission_parts import EventTreeDefinition, GroupDefinition
from tracerisk.prm.other_models.logic.model import (
    ALWAYS,
    NEVER,
    Container,
    ElementError,
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    Locations,
    LogicModel,
    Place,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate

_LAWS = {law.value: law for law in CommonCauseLaw}
_LEAST_LEVELS = {CommonCauseLaw.MGL: 2}


def read_openpra(path: Path | str) -> LogicModel:
    """Read the model that a JSON file of the OpenPRA engine holds.

    Raises ModelError, with the path of the element and its place in the file, when the file cannot
    be read, is not JSON, or is not what the engine takes.
    """
    try:
        data = file_bytes(path, MOST_WRITTEN)
    except OSError as error:
        raise ModelError(
            f"cannot be read: {error.strerror or error}", Location(str(path))
        ) from error
    return loads_openpra(data, str(path))


def loads_openpra(text: str | bytes, file: str) -> LogicModel:
    """Read a model from JSON text; `file` is its name in messages.

    Raises ModelError as `read_openpra` does.
    """
    if isinstance(text, bytes):
        text = _decoded(text, file)
    if not text.strip():
        raise ModelError("is empty; expected a JSON file", Location(file))
    with collection_paused():
        document = read_document(text, file)
        entries = document.entries()
        if "model" in entries:
            # A request to the engine: the settings say how it solves, not what.
            entries = document.fields({"model"}, optional={"settings", "tracerisk"})
            if "settings" in entries:
                entries["settings"].entries()
            return _model_of(entries["model"], entries.get("tracerisk"))
        return _Reader(document).model()


def _model_of(element: Element, beside: Element | None) -> LogicModel:
    """Return the model of a request, with what our writer put beside it for the engine's sake."""
    if beside is None:
        return _Reader(element).model()
    restore_names(element, beside)
    fields = beside.entries()
    houses = fields["houseEvents"].each(Element.string) if "houseEvents" in fields else ()
    reader = _Reader(element, frozenset(houses))
    model = reader.model()
    if "ccfGroups" not in fields:
        return model
    groups = fields["ccfGroups"].each(lambda item: reader.group(item, is_written_out=True))
    with_groups = restored(model, groups)
    if with_groups is not None:
        return with_groups
    finding = (
        f"{fields['ccfGroups'].location}: the common cause groups do not fit the gates and events "
        "of the model, which count"
    )
    return replace(model, findings=(*model.findings, finding))


def _decoded(data: bytes, file: str) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ModelError(
            f"the byte 0x{data[error.start]:02X} is not UTF-8; save the file as UTF-8",
            Location(file, line),
        ) from error


class _Reader:
    """Reads one model."""

    def __init__(self, element: Element, shared_houses: frozenset[str] = frozenset()) -> None:
        self._element = element
        self._shared_houses = shared_houses
        self._gates: list[GateDefinition] = []
        self._events: dict[str, tuple[float, EventDefinition, Element]] = {}
        self._houses: dict[str, tuple[HouseDefinition, Element]] = {}
        self._containers: list[Container] = []
        self._members: dict[str, GroupDefinition] = {}
        self._findings: list[str] = []
        self._elements: dict[tuple[str, str], Element] = {}

    def model(self) -> LogicModel:
        """Return the model."""
        fields = self._element.fields(
            (), optional={"name", "description", "faultTrees", "eventTrees", "ccfGroups"}
        )
        trees = fields["faultTrees"].items() if "faultTrees" in fields else ()
        named = self._names(trees)
        for element in trees:
            self._events_of(element)
        for element in trees:
            self._fault_tree(element, named)
        groups = fields["ccfGroups"].each(self.group) if "ccfGroups" in fields else ()
        events = tuple(
            # The figure of a member is that of its group, which is in no fault tree.
            EventDefinition(name) if name in self._members else event
            for name, (_, event, _) in self._events.items()
        )
        event_trees: tuple[EventTreeDefinition, ...] = ()
        if "eventTrees" in fields:
            event_trees = fields["eventTrees"].each(lambda item: read_event_tree(item, named))
        try:
            return LogicModel(
                fields["name"].string() if "name" in fields else "",
                tuple(self._gates),
                events,
                tuple(house for house, _ in self._houses.values()),
                groups=groups,
                event_trees=event_trees,
                containers=tuple(self._containers),
                label=fields["description"].string() if "description" in fields else "",
                findings=tuple(self._findings),
                locations=Locations(self._elements),
            )
        except ElementError as error:
            element = self._elements.get((error.kind, error.element), self._element)
            raise ModelError(error.message, element.location) from error

    def _names(self, trees: tuple[Element, ...]) -> dict[str, str]:
        """Return the fault trees by name, each with the name of its top gate."""
        named: dict[str, str] = {}
        for element in trees:
            parts = self._parts(element)
            name = parts["name"].string()
            if name in named:
                parts["name"].fail(f"'{name}' names two fault trees; rename one")
            top = parts["top"].entries()
            named[name] = top["name"].string() if "name" in top else name
        return named

    def _parts(self, element: Element) -> dict[str, Element]:
        return element.fields(
            {"name", "top"}, optional={"description", "basicEvents", "houseEvents"}
        )

    def _events_of(self, element: Element) -> None:
        """Read the events that a fault tree lists; several may list one, if they agree."""
        elements = self._parts(element)
        home = Place(elements["name"].string())
        for item in elements["basicEvents"].items() if "basicEvents" in elements else ():
            parts = item.fields({"name", "p"}, optional={"description"})
            name = parts["name"].string()
            p = parts["p"].number()
            if not 0.0 <= p <= 1.0:
                parts["p"].fail(f"probability {p!r} is outside [0, 1]")
            if name in (ALWAYS, NEVER):
                continue
            if name in self._shared_houses and p in (0.0, 1.0):
                self._house(name, p == 1.0, item, parts["p"], home)
                continue
            known = self._events.get(name)
            if known is not None and known[0] != p:
                parts["p"].fail(
                    f"is {p!r}, but '{name}' has {known[0]!r} at {known[2].location}; "
                    "give an event one figure, or rename one"
                )
            if known is None:
                place = Place(home.home, label=_label(parts))
                self._events[name] = (p, EventDefinition(name, Number(p), place), item)
                self._elements["basic event", name] = item
        for item in elements["houseEvents"].items() if "houseEvents" in elements else ():
            parts = item.fields({"name", "state"}, optional={"description"})
            state = parts["state"]
            self._house(parts["name"].string(), state.boolean(), item, state, home)

    def _house(self, name: str, state: bool, item: Element, where: Element, home: Place) -> None:
        listed = self._houses.get(name)
        if listed is not None and listed[0].house.state != state:
            where.fail(
                f"is {str(state).lower()}, at {listed[1].location} it is not; "
                "give one house event one state, or rename one"
            )
        if listed is None:
            label = _label(item.entries())
            house = HouseDefinition(HouseEvent(name, state), Place(home.home, label=label))
            self._houses[name] = (house, item)
            self._elements["house event", name] = item

    def _fault_tree(self, element: Element, named: dict[str, str]) -> None:
        parts = self._parts(element)
        name = parts["name"].string()
        self._containers.append(Container(name, label=_label(parts)))
        home = Place(name)
        known = {gate_definition.name: gate_definition for gate_definition in self._gates}
        for gate, nested, place in read_logic(parts["top"], named[name], self._find(named)):
            self._elements.setdefault(("gate", gate.name), place)
            if gate.name not in known:
                self._gates.append(GateDefinition(gate, home, nested))
                known[gate.name] = self._gates[-1]
            elif known[gate.name].gate != gate:
                place.fail(
                    f"'{gate.name}' names two different gates, one at "
                    f"{self._elements['gate', gate.name].location}; rename one"
                )
            self._report_duplicates(gate, place)

    def _find(self, named: dict[str, str]) -> dict[str, str]:
        """Return what each name in a formula stands for: events, and tops of fault trees."""
        events = {ALWAYS: ALWAYS, NEVER: NEVER} | named
        events |= {name: name for name in self._events}
        events |= {name: name for name in self._houses}
        return events

    def _report_duplicates(self, gate: Gate, place: Element) -> None:
        if len(set(gate.inputs)) < len(gate.inputs):
            twice = sorted(name for name, count in Counter(gate.inputs).items() if count > 1)
            self._findings.append(
                f"{place.location}: gate '{gate.name}' has duplicate inputs: {', '.join(twice)}"
            )

    def group(self, element: Element, *, is_written_out: bool = False) -> GroupDefinition:
        """Return a common cause group; its members are gates where it is written out."""
        fields = element.fields(
            {"name", "model", "members"}, optional={"description", "distribution", "factors"}
        )
        name = fields["name"].string()
        law = _LAWS[fields["model"].choice(_LAWS)]
        members = fields["members"].each(Element.string)
        known = {gate.name for gate in self._gates} if is_written_out else set()
        for index, member in enumerate(members):
            if member not in self._events and member not in known:
                fields["members"].items()[index].fail(
                    f"member '{member}' is not a basic event; {suggestion(self._events, member)}"
                )
        own = {self._events[member][0] for member in members if member in self._events}
        if "distribution" in fields:
            distribution = fields["distribution"].number()
            if not 0.0 <= distribution <= 1.0:
                fields["distribution"].fail(f"probability {distribution!r} is outside [0, 1]")
            if own - {distribution}:
                self._findings.append(
                    f"{element.location}: the members of '{name}' have figures of their own; the "
                    f"figure of the group, {distribution!r}, is used"
                )
        elif len(own) == 1:
            distribution = own.pop()
        else:
            element.fail("'distribution' is missing, and its members have different figures")
        factors = self._factors(fields, law, len(members), element)
        group = GroupDefinition(
            name, law, members, Number(distribution), factors, Place(label=_label(fields))
        )
        self._elements["common cause group", name] = element
        self._members |= dict.fromkeys(members, group)
        return group

    def _factors(
        self, found: dict[str, Element], law: CommonCauseLaw, count: int, element: Element
    ) -> tuple[tuple[int, Expression], ...]:
        least = count if law is CommonCauseLaw.BETA else _LEAST_LEVELS.get(law, 1)
        factors: dict[int, Expression] = {}
        level = least - 1
        for item in found["factors"].items() if "factors" in found else ():
            parts = item.fields({"value"}, optional={"level"})
            level = parts["level"].integer() if "level" in parts else level + 1
            if not least <= level <= count:
                item.fail(f"the level {level} of {law.value}; allowed: {least} to {count}")
            if level in factors:
                item.fail(f"duplicate level {level}; give each level once")
            factors[level] = Number(parts["value"].number())
        if not factors:
            element.fail("'factors' are missing; give at least one")
        return tuple(sorted(factors.items()))


def _label(parts: dict[str, Element]) -> str:
    return parts["description"].string() if "description" in parts else ""
