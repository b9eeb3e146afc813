"""Formulas of Open-PSA: gates out of elements, nested ones with names of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.formats.open_psa.stochastic import read_bool, read_int
from tracerisk.prm.other_models.formats.open_psa.xml_elements import Element
from tracerisk.prm.other_models.logic.model import ALWAYS, NEVER
from tracerisk.prm.trees.gates import Gate, GateKind, check_gate

_NO_CONNECTIVES = (GateKind.INHIBIT, GateKind.TRANSFER)
CONNECTIVES = {kind.value: kind for kind in GateKind if kind not in _NO_CONNECTIVES}
EVENTS: dict[str, str | None] = {
    "event": None,
    "gate": "gate",
    "basic-event": "basic event",
    "house-event": "house event",
}
"""The elements that refer to events, and the kind that each asks for."""
_FLAT = frozenset((GateKind.AND, GateKind.OR, GateKind.NOT, GateKind.NAND, GateKind.NOR))
_TYPES = ("gate", "basic-event", "house-event")
TAGS = frozenset((*CONNECTIVES, *EVENTS, "constant"))

Find = Callable[[Element, str | None], str]
"""Gives the full name of the gate or event that an element refers to, of the kind asked for."""


@dataclass(frozen=True, slots=True)
class Unresolved:
    """A gate whose inputs are not yet looked up."""

    name: str
    """Full name of the gate."""
    kind: GateKind
    """How the inputs are joined."""
    inputs: tuple[Element | str, ...]
    """Elements that refer to events, and names of nested gates and constants."""
    element: Element
    """Element of the formula, for messages."""
    k: int | None = None
    """Least number of inputs that must happen, of `atleast` and `cardinality`; else `None`."""
    most: int | None = None
    """Greatest number of inputs that may happen, of `cardinality`; else `None`."""

    def resolved(self, find: Find, plain: Mapping[str, str] | None = None) -> Gate:
        """Return the gate, its inputs found.

        `plain` are the kinds of events by name, where no name has several meanings; what it holds
        needs no search.
        Raises ModelError, with the position, for an input that is not there, and for inputs or
        numbers that do not fit the connective.
        """
        known = plain or {}
        names = []
        for element in self.inputs:
            if isinstance(element, str):
                names.append(element)
                continue
            written = element.attributes.get("name", "")
            kind = known.get(written)
            if kind is not None and kind == EVENTS.get(element.tag):
                names.append(written)
            else:
                names.append(find(element, kind_asked(element)))
        inputs = tuple(names)
        gate = Gate(self.name, self.kind, inputs, self.k, self.most)
        try:
            check_gate(gate)
        except ModelError as error:
            raise ModelError(error.message, self.element.location) from error
        return gate


def kind_asked(element: Element) -> str | None:
    """Return the kind of event that a reference asks for, or none.

    Raises ModelError for a type that is not known.
    """
    if element.tag != "event":
        return EVENTS[element.tag]
    asked = element.attributes.get("type")
    if asked is None:
        return None
    asked = asked.strip()
    if asked not in _TYPES:
        element.fail(f"<event> has the type '{asked}'; allowed: {', '.join(sorted(_TYPES))}")
    return EVENTS[asked]


def read_formula(element: Element, name: str) -> list[Unresolved]:
    """Return the gate of the formula, with that name, and those nested in it, in their order.

    The nested ones are named `name#1`, `name#2`, in the order in which they begin.
    Raises ModelError, with the position, for what is not a formula.
    """
    connective = CONNECTIVES.get(element.tag)
    if connective in _FLAT and element.children:
        # The common case, a formula of events alone, needs no search for nested ones.
        flat = tuple(element.children)
        if all(child.tag in EVENTS for child in flat):
            return [Unresolved(name, connective, flat, element)]
    s: list[Unresolved | None] = []
    _visit(element, name, s)
    return [gate for gate in s if gate is not None]


def _visit(node: Element, name: str, found: list[Unresolved | None]) -> str:
    """Put the gate of a formula, and those nested in it, among those found; return its name."""
    tag = node.tag
    place = len(found)
    own = f"{name}#{place}" if place else name
    found.append(None)
    if tag in EVENTS:
        found[place] = Unresolved(own, GateKind.TRANSFER, (node,), node)
        return own
    if tag == "constant":
        found[place] = Unresolved(own, GateKind.TRANSFER, (constant(node),), node)
        return own
    kind = CONNECTIVES.get(tag)
    if kind is None:
        node.unexpected(TAGS)
    inputs: list[Element | str] = []
    for child in node.children:
        if child.tag in EVENTS:
            inputs.append(child)
        elif child.tag == "constant":
            inputs.append(constant(child))
        else:
            inputs.append(_visit(child, name, found))
    if not inputs:
        node.fail(f"<{tag}> has no arguments; give it at least one")
    k = most = None
    if kind is GateKind.ATLEAST:
        k = read_int(node, "min")
    elif kind is GateKind.CARDINALITY:
        k, most = read_int(node, "min"), read_int(node, "max")
    found[place] = Unresolved(own, kind, tuple(inputs), node, k, most)
    return own


def constant(element: Element) -> str:
    """Return the name of the constant that an element states."""
    return ALWAYS if read_bool(element) else NEVER
