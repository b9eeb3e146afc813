"""Open-PSA XML files, one or several, as one model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from tracerisk.errors import Location, ModelError, one_of
from tracerisk.prm.collection import collection_paused
from tracerisk.prm.expressions import Definitions, Expression
from tracerisk.prm.fault_tree import HouseEvent
from tracerisk.prm.formats.open_psa.formulas import Unresolved, constant, read_formula
from tracerisk.prm.formats.open_psa.rewriting import (
    NAMES_MARK,
    NO_HOME,
    read_mark,
    read_name,
)
from tracerisk.prm.formats.open_psa.scopes import Scope
from tracerisk.prm.formats.open_psa.stochastic import (
    UNITS,
    read_bool,
    read_expression,
    read_float,
    read_int,
)
from tracerisk.prm.formats.open_psa.xml_elements import Element, parse
from tracerisk.prm.gates import Gate
from tracerisk.prm.logic_model import (
    NEVER,
    Alignment,
    Attribute,
    Container,
    ElementError,
    EventDefinition,
    GateDefinition,
    GroupDefinition,
    HouseDefinition,
    LogicModel,
    ParameterDefinition,
    Phase,
    Place,
    Substitution,
)

ROOT = "opsa-mef"
CONTAINERS = frozenset((ROOT, "model-data", "define-fault-tree", "define-component"))
_NOTES = ("label", "attributes")


def read_open_psa(path: Path | str, *more: Path | str) -> LogicModel:
    """Read the model that one or several Open-PSA XML files hold together.

    Raises ModelError with file, line and column, and what is allowed, when a file cannot be read,
    is no XML, declares entities, or holds what Open-PSA or this reader does not allow.
    """
    return _read([(Path(each), str(each)) for each in (path, *more)])


def loads_open_psa(text: str | bytes, file: str) -> LogicModel:
    """Read a model from XML text; `file` is its name in messages.

    Raises ModelError as `read_open_psa` does.
    """
    return _read([(text.encode() if isinstance(text, str) else text, file)])


def _read(sources: list[tuple[Path | bytes, str]]) -> LogicModel:
    reader = _Reader()
    with collection_paused():
        for source, file in sources:
            root = parse(source, file, CONTAINERS, reader.enter, reader.take)
            if root.tag != ROOT:
                root.fail(f"<{root.tag}> is no Open-PSA model; the root is <{ROOT}>")
            reader.finish_file(root)
        return reader.model()


class _Home(NamedTuple):
    """Where a definition stands: the path of its home, and whether it is private there."""

    path: str
    private: bool


@dataclass(slots=True)
class _Pending:
    """A definition that can be read once all names are known."""

    element: Element
    name: str
    place: Place
    body: Element | None = None


class _Reader:
    """Takes definitions as they come, and makes the model when all of them are there."""

    def __init__(self) -> None:
        self._homes: list[_Home] = []
        self._home = _Home("", False)
        self._events = Scope("gate or event")
        self._parameters = Scope("parameter")
        self._gates: list[tuple[list[Unresolved], Place]] = []
        self._basic: list[_Pending] = []
        self._houses: list[HouseDefinition] = []
        self._defined: list[_Pending] = []
        self._groups: list[_Pending] = []
        self._trees: list[Element] = []
        self._alignments: list[Alignment] = []
        self._substitutions: list[Element] = []
        self._containers: list[Container] = []
        self._paths: dict[str, Element] = {}
        self._places: dict[_Home, Place] = {}
        self._findings: list[str] = []
        self._files: dict[str, Element] = {}
        self._escaped: dict[str, bool] = {}
        self._root = ("", "", ())  # type: tuple[str, str, tuple[Attribute, ...]]
        self._taken: dict[str, Callable[[Element], None]] = {
            "define-gate": self._gate,
            "define-basic-event": self._basic_event,
            "define-house-event": self._house_event,
            "define-parameter": self._parameter,
            "define-CCF-group": self._group,
            "define-event-tree": self._trees.append,
            "define-initiating-event": self._trees.append,
            "define-rule": self._trees.append,
            "define-alignment": self._alignment,
            "define-substitution": self._substitutions.append,
        }
        inside = ("define-gate", "define-basic-event", "define-house-event", "define-parameter")
        self._allowed = {
            ROOT: {*self._taken, "define-fault-tree", "model-data"}
            - {"define-gate", "define-basic-event", "define-house-event", "define-parameter"},
            "model-data": set(inside) - {"define-gate"},
            "define-fault-tree": {*inside, "define-CCF-group", "define-component"},
            "define-component": {*inside, "define-CCF-group", "define-component"},
        }
        self._inside: list[str] = []

    def enter(self, element: Element) -> None:
        """Go into a container."""
        tag = element.tag
        if self._inside:
            self._check_place(element)
        elif tag == ROOT:
            self._files[element.file] = element
        self._inside.append(tag)
        if tag in (ROOT, "model-data"):
            self._homes.append(_Home("", False))
        else:
            short = self._short(element)
            above = self._home
            path = f"{above.path}.{short}" if above.path else short
            if path == NO_HOME and self._is_escaped(element):
                self._home = _Home("", False)
                self._homes.append(self._home)
                return
            if path in self._paths:
                first = self._paths[path].location
                element.fail(f"'{path}' is defined twice, first at {first}; rename one")
            self._paths[path] = element
            private = self._private(element)
            self._containers.append(Container(path, private))
            self._homes.append(_Home(path, private))
        self._home = self._homes[-1]

    def take(self, element: Element) -> None:
        """Take a definition, or leave a container."""
        if element.tag in CONTAINERS:
            self._leave(element)
            return
        if not self._inside:
            return
        self._check_place(element)
        self._taken[element.tag](element)

    def finish_file(self, root: Element) -> None:
        """Keep the name and remarks of a file's root; of several, the first that has any."""
        root.check_attributes("name")
        label, attributes = self._notes(root)
        name = root.attributes.get("name", "")
        if self._is_escaped(root):
            name = read_name(name)
            attributes = tuple(each for each in attributes if each.name != NAMES_MARK)
        found = (name, label, attributes)
        if self._root == ("", "", ()):
            self._root = found

    def model(self) -> LogicModel:
        """Return the model.

        Raises ModelError, with the position, for what does not hold together.
        """
        from tracerisk.prm.formats.open_psa.event_trees import EventTrees, Source, read_event_trees

        groups = [self._read_group(each) for each in self._groups]
        events = tuple(self._read_basic(each) for each in self._basic)
        members = tuple(
            EventDefinition(member, None, Place(group.place.home, group.place.private))
            for group in groups
            for member in group.members
        )
        gates = self._read_gates()
        parameters = tuple(self._read_parameter(each) for each in self._defined)
        trees = EventTrees()
        if self._trees:
            definitions = Definitions(tuple((each.name, each.expression) for each in parameters))
            source = Source(
                self._find_public,
                self._expression,
                self._name,
                self._attribute_name,
                self._place,
                definitions,
            )
            trees = read_event_trees(self._trees, source)
        substitutions = tuple(self._read_substitution(each, gates) for each in self._substitutions)
        gates += [GateDefinition(gate, nested=True) for gate in trees.gates]
        locations: dict[tuple[str, str], Location] = {}
        for element, key in self._positions():
            locations[key] = element.location
        name, label, attributes = self._root
        try:
            return LogicModel(
                name,
                tuple(gates),
                (*events, *members),
                tuple(self._houses),
                parameters,
                tuple(groups),
                trees.trees,
                trees.initiating_events,
                tuple(self._alignments),
                substitutions,
                tuple(self._containers),
                label,
                attributes,
                tuple(self._findings),
                locations,
            )
        except ElementError as error:
            place = locations.get((error.kind, error.element))
            raise ModelError(error.message, place) from error

    def _positions(self) -> list[tuple[Element, tuple[str, str]]]:
        found = [
            (element, (self._events.kinds[name], name))
            for name, element in self._events.elements.items()
        ]
        found += [
            (element, ("parameter", name)) for name, element in self._parameters.elements.items()
        ]
        found += [(each.element, ("common cause group", each.name)) for each in self._groups]
        found += [(each, ("substitution", self._name(each))) for each in self._substitutions]
        return found

    def _check_place(self, element: Element) -> None:
        allowed = self._allowed[self._inside[-1]]
        if element.tag not in allowed:
            element.fail(
                f"<{element.tag}> does not belong in <{self._inside[-1]}>; "
                f"{one_of(allowed, element.tag)}"
            )

    def _leave(self, element: Element) -> None:
        self._inside.pop()
        self._homes.pop()
        path = self._home.path
        self._home = self._homes[-1] if self._homes else _Home("", False)
        if element.tag in (ROOT, "model-data"):
            return
        element.check_attributes("name", "role")
        label, attributes = self._notes(element)
        if label or attributes:
            for index, each in enumerate(self._containers):
                if each.path == path:
                    self._containers[index] = replace(each, label=label, attributes=attributes)

    def _is_escaped(self, element: Element) -> bool:
        """Whether names in the element's file are written with escapes, as the writer's are."""
        found = self._escaped.get(element.file)
        if found is None:
            root = self._files.get(element.file)
            attributes = () if root is None else self._notes(root)[1]
            found = any(each.name == NAMES_MARK for each in attributes)
            self._escaped[element.file] = found
        return found

    def _short(self, element: Element) -> str:
        name = element.attributes.get("name") or element.attribute("name")
        if self._is_escaped(element):
            return read_name(name)
        if "." in name:
            element.fail(f"the name '{name}' has a point, which joins names to paths; rename it")
        return name

    def _name(self, element: Element) -> str:
        return self._attribute_name(element, "name")

    def _attribute_name(self, element: Element, attribute: str) -> str:
        name = element.attribute(attribute)
        return read_name(name) if self._is_escaped(element) else name

    def _private(self, element: Element) -> bool:
        role = element.attributes.get("role")
        if role is None:
            return self._home.private
        if role not in ("public", "private"):
            element.fail(f"<{element.tag}> has the role '{role}'; allowed: private, public")
        if role == "private" and not self._home.path:
            element.fail(
                f"<{element.tag}> is private, in no fault tree; make it public, or move it"
            )
        return role == "private"

    def _place(self, element: Element) -> Place:
        """Return where a definition stands, and take its label and attributes out of it."""
        private = self._private(element)
        children = element.children
        if children and children[0].tag in _NOTES:
            label, attributes = self._notes(element)
            element.children = [child for child in children if child.tag not in _NOTES]
            return Place(self._home.path, private, label, attributes)
        home = _Home(self._home.path, private)
        place = self._places.get(home)
        if place is None:
            place = self._places[home] = Place(*home)
        return place

    def _notes(self, element: Element) -> tuple[str, tuple[Attribute, ...]]:
        label = ""
        attributes: list[Attribute] = []
        for child in element.children:
            if child.tag == "label":
                label = child.text.strip()
            elif child.tag == "attributes":
                for each in child.children:
                    if each.tag != "attribute":
                        each.unexpected(("attribute",))
                    value = each.attributes.get("value", "")
                    attributes.append(
                        Attribute(each.attribute("name"), value, each.attributes.get("type", ""))
                    )
        return label, tuple(attributes)

    def _gate(self, element: Element) -> None:
        element.check_attributes("name", "role")
        place = self._place(element)
        name = self._events.add(
            element, "gate", self._short(element), place.home, private=place.private
        )
        if len(element.children) != 1:
            element.fail(f"gate '{name}' has {len(element.children)} formulas; give it exactly one")
        self._gates.append((read_formula(element.children[0], name), place))

    def _basic_event(self, element: Element) -> None:
        element.check_attributes("name", "role")
        place = self._place(element)
        name = self._events.add(
            element, "basic event", self._short(element), place.home, private=place.private
        )
        if len(element.children) > 1:
            element.fail(f"basic event '{name}' has several expressions; give it one")
        self._basic.append(
            _Pending(element, name, place, element.children[0] if element.children else None)
        )

    def _house_event(self, element: Element) -> None:
        element.check_attributes("name", "role")
        place = self._place(element)
        name = self._events.add(
            element, "house event", self._short(element), place.home, private=place.private
        )
        state = False
        if element.children:
            child = element.one_child()
            if child.tag != "constant":
                child.unexpected(("constant",))
            state = read_bool(child)
        self._houses.append(HouseDefinition(HouseEvent(name, state), place))

    def _parameter(self, element: Element) -> None:
        element.check_attributes("name", "role", "unit")
        place = self._place(element)
        name = self._parameters.add(
            element, "parameter", self._short(element), place.home, private=place.private
        )
        unit = element.attributes.get("unit", "")
        if unit and unit not in UNITS:
            element.fail(f"parameter '{name}' has the unit '{unit}'; {one_of(UNITS, unit)}")
        self._defined.append(_Pending(element, name, place, element.one_child()))

    def _group(self, element: Element) -> None:
        element.check_attributes("name", "model")
        name = self._name(element)
        place = self._place(element)
        self._groups.append(_Pending(element, name, place))
        for child in element.children:
            if child.tag == "members":
                for member in child.children:
                    if member.tag != "basic-event":
                        member.unexpected(("basic-event",))
                    short = self._short(member)
                    path = f"{place.home}.{short}" if place.private else short
                    if self._events.kinds.get(path) == "basic event":
                        self._findings.append(
                            f"{member.location}: '{path}' has a definition of its own; that of its "
                            f"common cause group '{name}' counts"
                        )
                        self._basic = [each for each in self._basic if each.name != path]
                    else:
                        self._events.add(
                            member, "basic event", short, place.home, private=place.private
                        )

    def _alignment(self, element: Element) -> None:
        place = self._place(element)
        phases = []
        for child in element.children:
            if child.tag != "define-phase":
                child.unexpected(("define-phase",))
            inner = self._place(child)
            houses = []
            for each in child.children:
                if each.tag != "set-house-event":
                    each.unexpected(("set-house-event",))
                houses.append((self._name(each), read_bool(each.one_child())))
            fraction = read_float(child, "time-fraction")
            if not 0.0 <= fraction <= 1.0:
                child.fail(f"the time-fraction {fraction!r} is outside [0, 1]; give a share")
            phases.append(Phase(self._name(child), fraction, tuple(houses), inner))
        self._alignments.append(Alignment(self._name(element), tuple(phases), place))

    def _find(self, element: Element, home: str, kind: str | None) -> str:
        self._unescape(element)
        return self._events.find(element, home, kind)

    def _find_public(self, element: Element, kind: str | None) -> str:
        return self._find(element, "", kind)

    def _expression(self, element: Element, home: str = "") -> Expression:
        def resolve(reference: Element) -> str:
            self._unescape(reference)
            return self._parameters.find(reference, home, None)

        return read_expression(element, resolve)

    def _unescape(self, element: Element) -> None:
        """Replace the name in a reference by that which was written; points join a path."""
        if self._is_escaped(element) and "name" in element.attributes:
            parts = element.attributes["name"].split(".")
            element.attributes["name"] = ".".join(map(read_name, parts))

    def _read_gates(self) -> list[GateDefinition]:
        gates: list[GateDefinition] = []
        for unresolved, place in self._gates:
            home = place.home

            def find(element: Element, kind: str | None, home: str = home) -> str:
                return self._find(element, home, kind)

            read = [each.resolved(find) for each in unresolved]
            if place.attributes and self._is_escaped(unresolved[0].element):
                marked, place = read_mark(read, place)
                nested, read = marked.nested, list(marked.gates)
            else:
                nested = False
            self._tell_duplicates(read, unresolved)
            gates.append(GateDefinition(read[0], place, nested))
            if len(read) > 1:
                inner = self._places.setdefault(
                    _Home(place.home, place.private), Place(place.home, place.private)
                )
                gates += [GateDefinition(gate, inner, nested=True) for gate in read[1:]]
        return gates

    def _tell_duplicates(self, gates: list[Gate], unresolved: list[Unresolved]) -> None:
        for gate in gates:
            if len(set(gate.inputs)) < len(gate.inputs):
                twice = sorted({name for name in gate.inputs if gate.inputs.count(name) > 1})
                self._findings.append(
                    f"{unresolved[0].element.location}: gate '{gate.name}' has an input twice: "
                    f"{', '.join(twice)}"
                )

    def _read_basic(self, pending: _Pending) -> EventDefinition:
        expression = None
        body = pending.body
        if body is not None:
            expression = self._expression(body, pending.place.home)
            if body.tag in ("float", "int", "bool"):
                value = expression.value((), 0.0)
                if not 0.0 <= value <= 1.0:
                    body.fail(
                        f"basic event '{pending.name}': probability {value!r} is outside [0, 1]; "
                        "give a number within"
                    )
        return EventDefinition(pending.name, expression, pending.place)

    def _read_parameter(self, pending: _Pending) -> ParameterDefinition:
        assert pending.body is not None
        return ParameterDefinition(
            pending.name,
            self._expression(pending.body, pending.place.home),
            pending.element.attributes.get("unit", ""),
            pending.place,
        )

    def _read_group(self, pending: _Pending) -> GroupDefinition:
        from tracerisk.prm.common_cause import CommonCauseLaw

        element, home = pending.element, pending.place.home
        laws = {law.value: law for law in CommonCauseLaw}
        law = element.attribute("model")
        if law not in laws:
            element.fail(f"the common cause model '{law}' is unknown; {one_of(laws, law)}")
        members: list[str] = []
        distribution: Expression | None = None
        factors: list[tuple[int, Expression]] = []
        for child in element.children:
            if child.tag == "members":
                members += [self._find(each, home, "basic event") for each in child.children]
            elif child.tag == "distribution":
                distribution = self._expression(child.one_child(), home)
            elif child.tag in ("factor", "factors"):
                for each in child.children if child.tag == "factors" else (child,):
                    if each.tag != "factor":
                        each.unexpected(("factor",))
                    level = self._level(each, laws[law].value, len(members), factors)
                    factors.append((level, self._expression(each.one_child(), home)))
            else:
                child.unexpected(("members", "distribution", "factors", "factor"))
        if distribution is None:
            element.fail(f"common cause group '{pending.name}' has no <distribution>; give it one")
        if not factors:
            element.fail(f"common cause group '{pending.name}' has no <factor>; give it one")
        factors.sort(key=lambda factor: factor[0])
        return GroupDefinition(
            pending.name, laws[law], tuple(members), distribution, tuple(factors), pending.place
        )

    def _level(
        self, element: Element, law: str, count: int, before: list[tuple[int, Expression]]
    ) -> int:
        """Return the level of a factor: as stated, else the next one of the law."""
        least = {"beta-factor": count, "MGL": 2}.get(law, 1)
        if "level" not in element.attributes:
            return before[-1][0] + 1 if before else least
        level = read_int(element, "level")
        if not least <= level <= count:
            element.fail(f"the level {level} of {law}; allowed: {least} to {count}")
        if any(level == other for other, _ in before):
            element.fail(f"the level {level} stands twice; give each once")
        return level

    def _read_substitution(self, element: Element, gates: list[GateDefinition]) -> Substitution:
        name = self._name(element)
        place = self._place(element)
        hypothesis = ""
        target: str | bool | None = None
        sources: tuple[str, ...] = ()
        for child in element.children:
            if child.tag == "hypothesis":
                own = f"{name}#hypothesis"
                read = [
                    each.resolved(self._find_public)
                    for each in read_formula(child.one_child(), own)
                ]
                gates += [GateDefinition(gate, Place(), nested=True) for gate in read]
                hypothesis = own
            elif child.tag == "source":
                sources = tuple(self._find(each, "", "basic event") for each in child.children)
            elif child.tag == "target":
                inner = child.one_child()
                target = (
                    constant(inner) != NEVER
                    if inner.tag == "constant"
                    else self._find(inner, "", "basic event")
                )
            else:
                child.unexpected(("hypothesis", "source", "target"))
        if not hypothesis or target is None:
            element.fail(f"substitution '{name}' needs a <hypothesis> and a <target>")
        kind = element.attributes.get("type", "")
        return Substitution(name, hypothesis, target, sources, kind, place)
