"""What stands in Open-PSA files, taken definition by definition, with where it stands."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass, replace

from tracerisk.errors import one_of
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.formats.open_psa.formulas import Unresolved, read_formula
from tracerisk.prm.other_models.formats.open_psa.rewriting import NAMES_MARK, NO_HOME, read_name
from tracerisk.prm.other_models.formats.open_psa.scopes import Scope
from tracerisk.prm.other_models.formats.open_psa.stochastic import (
    UNITS,
    read_bool,
    read_expression,
    read_float,
)
from tracerisk.prm.other_models.formats.open_psa.xml_elements import Element
from tracerisk.prm.other_models.logic.model import Attribute, Container, HouseDefinition, Place
from tracerisk.prm.trees.events import HouseEvent

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NamedTuple

    from tracerisk.prm.other_models.formats.open_psa.rewriting import NameForm
    from tracerisk.prm.other_models.logic.mission_parts import Alignment

    class Home(NamedTuple):
        """Where a definition stands: the path of its home, and whether it is private there."""

        path: str
        """Dotted path of the fault tree or component; "" for the model."""
        private: bool
        """Whether what is defined there is private."""

else:
    Home = namedtuple("Home", ("path", "private"))
ROOT = "opsa-mef"
ROOTS = (ROOT, "open-psa")
"""What the root of a file is called; the second is that of older tools."""
CONTAINERS = frozenset((ROOT, "model-data", "define-fault-tree", "define-component"))
_NOTES = ("label", "attributes")


@dataclass(slots=True)
class Pending:
    """A definition that can be read once all names are known."""

    element: Element
    """The element of the definition."""
    name: str
    """Full name."""
    place: Place
    """Where it is defined."""
    body: Element | None = None
    """Element of its expression; `None` where there is none."""


class Collector:
    """Takes definitions as they come, and makes the model when all of them are there."""

    def __init__(self) -> None:
        self._homes: list[Home] = []
        self._home = Home("", False)
        self.events = Scope("gate or event")
        self.parameters = Scope("parameter")
        self.gates: list[tuple[list[Unresolved], Place]] = []
        self.basic: list[Pending] = []
        self.houses: list[HouseDefinition] = []
        self.defined: list[Pending] = []
        self.groups: list[Pending] = []
        self.trees: list[Element] = []
        self.alignments: list[Alignment] = []
        self.substitutions: list[Element] = []
        self.containers: list[Container] = []
        self._paths: dict[str, Element] = {}
        self.places: dict[Home, Place] = {}
        self.findings: list[str] = []
        self._files: dict[str, Element] = {}
        self._forms: dict[str, NameForm] = {}
        self.root = ("", "", ())  # type: tuple[str, str, tuple[Attribute, ...]]
        self._taken: dict[str, Callable[[Element], None]] = {
            "define-gate": self._gate,
            "define-basic-event": self._basic_event,
            "define-house-event": self._house_event,
            "define-parameter": self._parameter,
            "define-CCF-group": self._group,
            "define-event-tree": self.trees.append,
            "define-initiating-event": self.trees.append,
            "define-rule": self.trees.append,
            "define-alignment": self._alignment,
            "define-substitution": self.substitutions.append,
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
        self._members: dict[str, str] = {}

    def enter(self, element: Element) -> None:
        """Go into a container."""
        tag = element.tag
        if self._inside:
            self._check_place(element)
        elif tag == ROOT:
            self._files[element.file] = element
        self._inside.append(tag)
        if tag in (ROOT, "model-data"):
            self._homes.append(Home("", False))
        else:
            short = self._short(element)
            above = self._home
            path = f"{above.path}.{short}" if above.path else short
            if path == NO_HOME and self.name_form(element):
                self._home = Home("", False)
                self._homes.append(self._home)
                return
            if path in self._paths:
                first = self._paths[path].location
                element.fail(f"'{path}' is defined twice, first at {first}; rename one")
            self._paths[path] = element
            private = self._private(element)
            self.containers.append(Container(path, private))
            self._homes.append(Home(path, private))
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

    def release(self) -> None:
        """Drop what refers back to this, so that all that was read is freed with it."""
        self._taken.clear()

    def finish_file(self, root: Element) -> None:
        """Keep the name and remarks of a file's root; of several, the first that has any."""
        root.check_attributes("name")
        label, attributes = self._notes(root)
        name = root.attributes.get("name", "")
        form = self.name_form(root)
        if form:
            name = read_name(name, form)
            attributes = tuple(
                attribute for attribute in attributes if attribute.name != NAMES_MARK
            )
        row = (name, label, attributes)
        if self.root == ("", "", ()):
            self.root = row

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
        self._home = self._homes[-1] if self._homes else Home("", False)
        if element.tag in (ROOT, "model-data"):
            return
        element.check_attributes("name", "role")
        label, attributes = self._notes(element)
        if label or attributes:
            for index, container in enumerate(self.containers):
                if container.path == path:
                    self.containers[index] = replace(container, label=label, attributes=attributes)

    def name_form(self, element: Element) -> NameForm:
        """Return how names in the element's file are written: the writer's have a mark."""
        form = self._forms.get(element.file)
        if form is None:
            root = self._files.get(element.file)
            attributes = () if root is None else self._notes(root)[1]
            marks = [attribute.value for attribute in attributes if attribute.name == NAMES_MARK]
            form = ("readable" if "readable" in marks else "escaped") if marks else ""
            self._forms[element.file] = form
        return form

    def _short(self, element: Element) -> str:
        name = element.attributes.get("name") or element.attribute("name")
        form = self.name_form(element)
        if form:
            return read_name(name, form)
        if "." in name:
            element.fail(
                f"the name '{name}' contains a point, which separates the names of a "
                "path; rename it"
            )
        return name

    def name(self, element: Element) -> str:
        """Return the name that an element states."""
        return self.attribute_name(element, "name")

    def attribute_name(self, element: Element, attribute: str) -> str:
        """Return the name that an attribute states."""
        name = element.attribute(attribute)
        form = self.name_form(element)
        return read_name(name, form) if form else name

    def _private(self, element: Element) -> bool:
        role = element.attributes.get("role")
        if role is None:
            return self._home.private
        if role not in ("public", "private"):
            element.fail(f"<{element.tag}> has the role '{role}'; allowed: private, public")
        if role == "private" and not self._home.path:
            element.fail(
                f"<{element.tag}> is private outside any fault tree; make it public, or move it"
            )
        return role == "private"

    def place(self, element: Element) -> Place:
        """Return where a definition stands, and take its label and attributes out of it."""
        private = self._private(element)
        children = element.children
        if children and children[0].tag in _NOTES:
            label, attributes = self._notes(element)
            element.children = [child for child in children if child.tag not in _NOTES]
            return Place(self._home.path, private, label, attributes)
        home = Home(self._home.path, private)
        place = self.places.get(home)
        if place is None:
            place = self.places[home] = Place(*home)
        return place

    def _notes(self, element: Element) -> tuple[str, tuple[Attribute, ...]]:
        label = ""
        attributes: list[Attribute] = []
        for child in element.children:
            if child.tag == "label":
                label = child.text.strip()
            elif child.tag == "attributes":
                for item in child.children:
                    if item.tag != "attribute":
                        item.unexpected(("attribute",))
                    value = item.attributes.get("value", "")
                    attributes.append(
                        Attribute(item.attribute("name"), value, item.attributes.get("type", ""))
                    )
        return label, tuple(attributes)

    def _added(
        self, scope: Scope, element: Element, kind: str, *attributes: str
    ) -> tuple[str, Place]:
        """Add what an element defines to those of its kind; return its full name and its place."""
        element.check_attributes("name", "role", *attributes)
        place = self.place(element)
        name = scope.add(element, kind, self._short(element), place.home, private=place.private)
        return name, place

    def _gate(self, element: Element) -> None:
        name, place = self._added(self.events, element, "gate")
        if len(element.children) != 1:
            element.fail(f"gate '{name}' has {len(element.children)} formulas; give it exactly one")
        self.gates.append((read_formula(element.children[0], name), place))

    def _basic_event(self, element: Element) -> None:
        name, place = self._added(self.events, element, "basic event")
        if len(element.children) > 1:
            element.fail(f"basic event '{name}' has several expressions; give it one")
        self.basic.append(
            Pending(element, name, place, element.children[0] if element.children else None)
        )

    def _house_event(self, element: Element) -> None:
        name, place = self._added(self.events, element, "house event")
        state = False
        if element.children:
            child = element.one_child()
            if child.tag != "constant":
                child.unexpected(("constant",))
            state = read_bool(child)
        self.houses.append(HouseDefinition(HouseEvent(name, state), place))

    def _parameter(self, element: Element) -> None:
        name, place = self._added(self.parameters, element, "parameter", "unit")
        unit = element.attributes.get("unit", "")
        if unit and unit not in UNITS:
            element.fail(f"parameter '{name}' has the unit '{unit}'; {one_of(UNITS, unit)}")
        self.defined.append(Pending(element, name, place, element.one_child()))

    def _group(self, element: Element) -> None:
        element.check_attributes("name", "model")
        name = self.name(element)
        place = self.place(element)
        self.groups.append(Pending(element, name, place))
        for child in element.children:
            if child.tag == "members":
                for member in child.children:
                    if member.tag != "basic-event":
                        member.unexpected(("basic-event",))
                    short = self._short(member)
                    path = f"{place.home}.{short}" if place.private else short
                    if path in self._members:
                        member.fail(
                            f"'{path}' is a member of common cause group "
                            f"'{self._members[path]}' already; remove it from one"
                        )
                    self._members[path] = name
                    if self.events.kinds.get(path) == "basic event":
                        self.findings.append(
                            f"{member.location}: '{path}' has a definition of its own; the "
                            f"definition of its common cause group '{name}' is used"
                        )
                        self.basic = [pending for pending in self.basic if pending.name != path]
                    else:
                        self.events.add(
                            member, "basic event", short, place.home, private=place.private
                        )

    def _alignment(self, element: Element) -> None:
        from tracerisk.prm.other_models.logic.mission_parts import Alignment, Phase

        place = self.place(element)
        phases = []
        for child in element.children:
            if child.tag != "define-phase":
                child.unexpected(("define-phase",))
            inner = self.place(child)
            houses = []
            for item in child.children:
                if item.tag != "set-house-event":
                    item.unexpected(("set-house-event",))
                houses.append((self.name(item), read_bool(item.one_child())))
            fraction = read_float(child, "time-fraction")
            if not 0.0 <= fraction <= 1.0:
                child.fail(f"the time-fraction {fraction!r} is outside [0, 1]; give a share")
            phases.append(Phase(self.name(child), fraction, tuple(houses), inner))
        self.alignments.append(Alignment(self.name(element), tuple(phases), place))

    def plain_names(self) -> dict[str, str]:
        """Return the kind of each gate and event, if names are what they are in all homes."""
        if self.events.has_private or any(self._forms.values()):
            return {}
        return self.events.kinds

    def find(self, element: Element, home: str, kind: str | None) -> str:
        """Return the full name of the gate or event that an element in `home` refers to."""
        self._unescape(element)
        return self.events.find(element, home, kind)

    def find_public(self, element: Element, kind: str | None) -> str:
        """Return the full name of what an element outside all fault trees refers to."""
        return self.find(element, "", kind)

    def expression(self, element: Element, home: str = "") -> Expression:
        """Return the expression that an element in `home` is."""

        def resolve(reference: Element) -> str:
            self._unescape(reference)
            return self.parameters.find(reference, home, None)

        return read_expression(element, resolve)

    def _unescape(self, element: Element) -> None:
        """Replace the name in a reference by that which was written; points join a path."""
        form = self.name_form(element)
        if form and "name" in element.attributes:
            parts = element.attributes["name"].split(".")
            element.attributes["name"] = ".".join(read_name(part, form) for part in parts)
