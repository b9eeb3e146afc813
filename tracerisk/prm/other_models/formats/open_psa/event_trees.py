"""Event trees of Open-PSA, their initiating events and rules."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    EventSequence,
    Fork,
    Initiated,
    InitiatingEvent,
    InState,
    Instruction,
    Link,
    Path,
    Resume,
    SetHouse,
    Target,
    Weight,
    When,
)
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.expressions import Definitions, ExpressionModel, Number
from tracerisk.prm.other_models.formats.open_psa.formulas import (
    EVENTS,
    constant,
    kind_asked,
    read_formula,
)
from tracerisk.prm.other_models.formats.open_psa.rewriting import END_STATE_MARK, FREQUENCY_MARK
from tracerisk.prm.other_models.formats.open_psa.stochastic import read_bool
from tracerisk.prm.other_models.formats.open_psa.xml_elements import Element
from tracerisk.prm.other_models.logic.mission_parts import EventTreeDefinition
from tracerisk.prm.other_models.logic.model import Attribute, Place
from tracerisk.prm.trees.gates import Gate

if TYPE_CHECKING:
    from tracerisk.prm.other_models.formats.open_psa.collecting import Collector

_INSTRUCTIONS = (
    "block",
    "collect-expression",
    "collect-formula",
    "event-tree",
    "if",
    "rule",
    "set-house-event",
)
_SEQUENCE = "define-sequence"
_TARGETS = ("fork", "sequence", "branch")
_TESTS = ("and", "bool", "not", "or", "test-functional-event", "test-initiating-event")


@dataclass(slots=True)
class EventTrees:
    """What was read of event trees."""

    trees: tuple[EventTreeDefinition, ...] = ()
    """The event trees, in the order of the file."""
    initiating_events: tuple[InitiatingEvent, ...] = ()
    """Initiating events that begin no event tree."""
    gates: list[Gate] = field(default_factory=list)
    """Gates made for conditions that are formulas."""


def read_event_trees(source: Collector, definitions: Definitions) -> EventTrees:
    """Return the event trees that were collected, with what belongs to them.

    `definitions` are the parameters that their weights refer to.

    Raises ModelError, with the position, for what is malformed or does not fit an EventTree.
    """
    event_trees = EventTrees()
    elements = source.trees
    rules: dict[str, Element] = {}
    begun: dict[str, tuple[Element, Place]] = {}
    alone: list[InitiatingEvent] = []
    for element in elements:
        if element.tag == "define-rule":
            element.check_attributes("name")
            source.place(element)
            name = source.name(element)
            if name in rules:
                element.fail(
                    f"rule '{name}' is defined twice, first at {rules[name].location}; rename one"
                )
            rules[name] = element
        elif element.tag == "define-initiating-event":
            element.check_attributes("name", "event-tree")
            if "event-tree" not in element.attributes:
                alone.append(InitiatingEvent(source.name(element)))
                continue
            tree = source.attribute_name(element, "event-tree")
            if tree in begun:
                first = begun[tree][0].location
                element.fail(
                    f"the event tree '{tree}' has two initiating events, the first at {first}; "
                    "give each its own tree"
                )
            begun[tree] = (element, source.place(element))
    event_trees.initiating_events = tuple(alone)
    trees = []
    elsewhere = {
        source.name(child): child
        for element in elements
        if element.tag == "define-event-tree"
        for child in element.children
        if child.tag == _SEQUENCE
    }
    for element in elements:
        if element.tag == "define-event-tree":
            reader = _TreeReader(element, source, definitions, rules, event_trees.gates, elsewhere)
            trees.append(reader.read(begun.pop(reader.name, None)))
    for name, (element, _) in begun.items():
        names = [definition.name for definition in trees]
        element.fail(f"event tree '{name}' is not defined; {one_of(names, name)}")
    event_trees.trees = tuple(trees)
    return event_trees


class _TreeReader:
    """Reads one event tree."""

    def __init__(
        self,
        element: Element,
        source: Collector,
        definitions: Definitions,
        rules: dict[str, Element],
        gates: list[Gate],
        elsewhere: Mapping[str, Element],
    ) -> None:
        element.check_attributes("name")
        self.name = source.name(element)
        self._element = element
        self._source = source
        self._definitions = definitions
        self._rules = rules
        # Sequences of other event trees, by name; those of this one; those read, borrowed or own.
        self._elsewhere = elsewhere
        self._own = {source.name(child) for child in element.children if child.tag == _SEQUENCE}
        self._defined: set[str] = set()
        self._sequences: list[EventSequence] = []
        self._gates = gates
        self._conditions = 0
        self._notes: list[tuple[str, str, Place]] = []
        self._links: dict[str, tuple[Link, tuple[Instruction, ...]]] = {}

    def read(self, begun: tuple[Element, Place] | None) -> EventTreeDefinition:
        """Return the event tree, with its initiating event where one is given."""
        place = self._source.place(self._element)
        functions: list[str] = []
        branches: list[Branch] = []
        start: Branch | None = None
        initiating = None
        if begun is not None:
            element, result = begun
            result, mark = _unmarked(result, FREQUENCY_MARK)
            initiating = _initiating(element, self._source.name(element), mark)
            self._note("initiating-event", initiating.name, result)
        for child in self._element.children:
            if child.tag == "define-functional-event":
                functions.append(self._named(child, "functional-event"))
            elif child.tag == _SEQUENCE:
                self._sequence(child)
            elif child.tag == "define-branch":
                name = self._named(child, "branch")
                branches.append(self._branch(child, name))
            elif child.tag == "initial-state":
                start = self._branch(child, "")
            else:
                child.unexpected(
                    (
                        "define-functional-event",
                        _SEQUENCE,
                        "define-branch",
                        "initial-state",
                    )
                )
        if start is None:
            self._element.fail(f"event tree '{self.name}' has no <initial-state>; give it one")
        try:
            tree = EventTree(
                self.name,
                tuple(functions),
                start,
                tuple(self._sequences),
                tuple(branches),
                initiating,
            )
        except ModelError as error:
            raise ModelError(error.message, self._element.location) from error
        return EventTreeDefinition(tree, place, tuple(self._notes))

    def _named(self, element: Element, kind: str) -> str:
        element.check_attributes("name")
        name = self._source.name(element)
        self._note(kind, name, self._source.place(element))
        return name

    def _note(self, kind: str, name: str, place: Place) -> None:
        if place.label or place.attributes:
            self._notes.append((kind, name, place))

    def _sequence(self, element: Element) -> None:
        element.check_attributes("name")
        name = self._source.name(element)
        place, mark = _unmarked(self._source.place(element), END_STATE_MARK)
        self._note("sequence", name, place)
        if name in self._defined:
            element.fail(f"sequence '{name}' is defined twice in '{self.name}'; rename one")
        self._defined.add(name)
        children = self._with_links(element.children, ())
        links = [child for child in children if child.tag == "event-tree"]
        others = [child for child in children if child.tag != "event-tree"]
        instructions = tuple(self._instructions(others))
        if not links:
            end_state = mark.value if mark else ""
            self._sequences.append(EventSequence(name, end_state, instructions))
            return
        if len(links) > 1:
            links[1].fail(f"sequence '{name}' links to two event trees; allowed: one")
        self._links[name] = (Link(self._source.name(links[0])), instructions)

    def _with_links(self, elements: Sequence[Element], rules: tuple[str, ...]) -> list[Element]:
        """Return the elements, rules that lead into an event tree replaced by what is in them."""
        links = []
        for element in elements:
            name = self._source.name(element) if element.tag == "rule" else ""
            rule = self._rules.get(name) if name not in rules else None
            inner = [] if rule is None else self._with_links(rule.children, (*rules, name))
            links += inner if any(item.tag == "event-tree" for item in inner) else [element]
        return links

    def _branch(self, element: Element, name: str) -> Branch:
        target, instructions = self._course(element)
        return Branch(target, instructions, name)

    def _course(self, element: Element) -> tuple[Target, tuple[Instruction, ...]]:
        """Return where the instructions in an element lead, and these."""
        if not element.children or element.children[-1].tag not in _TARGETS:
            element.fail(
                f"<{element.tag}> leads nowhere; end it with a <fork>, <sequence> or <branch>"
            )
        *before, last = element.children
        instructions = tuple(self._instructions(before))
        if last.tag == "branch":
            return Resume(self._source.name(last)), instructions
        if last.tag == "sequence":
            name = self._source.name(last)
            if name not in (self._own | self._defined) and name in self._elsewhere:
                self._sequence(self._elsewhere[name])
            if name in self._links:
                link, more = self._links[name]
                return link, (*instructions, *more)
            return End(name), instructions
        last.check_attributes("functional-event")
        paths = []
        for child in last.children:
            if child.tag != "path":
                child.unexpected(("path",))
            child.check_attributes("state")
            target, inner = self._course(child)
            paths.append(Path(self._source.attribute_name(child, "state"), target, inner))
        return Fork(
            self._source.attribute_name(last, "functional-event"), tuple(paths)
        ), instructions

    def _instructions(
        self, elements: Sequence[Element], rules: tuple[str, ...] = ()
    ) -> Iterator[Instruction]:
        for element in elements:
            if element.tag == "block":
                yield from self._instructions(element.children, rules)
            elif element.tag == "rule":
                name = self._source.name(element)
                if name in rules:
                    element.fail(f"rule '{name}' refers to itself; break the cycle")
                if name not in self._rules:
                    element.fail(f"rule '{name}' is not defined; {one_of(self._rules, name)}")
                yield from self._instructions(self._rules[name].children, (*rules, name))
            elif element.tag == "collect-formula":
                yield self._condition(element.one_child())
            elif element.tag == "collect-expression":
                yield self._weight(element.one_child())
            elif element.tag == "set-house-event":
                element.check_attributes("name", "direction")
                house = self._source.find_public(element, "house event")
                yield SetHouse(house, read_bool(element.one_child()))
            elif element.tag == "if":
                yield from self._when(element, rules)
            elif element.tag == "event-tree":
                element.fail("a link to an event tree is allowed in a <define-sequence> only")
            else:
                element.unexpected(_INSTRUCTIONS)

    def _condition(self, formula: Element) -> Condition:
        happens = formula.tag != "not"
        inner = formula if happens else formula.one_child()
        if inner.tag in EVENTS:
            return Condition(self._source.find_public(inner, kind_asked(inner)), happens)
        if inner.tag == "constant":
            return Condition(constant(inner), happens)
        self._conditions += 1
        name = f"#{self.name}#{self._conditions}"
        self._gates += [
            unresolved.resolved(self._source.find_public)
            for unresolved in read_formula(inner, name)
        ]
        return Condition(name, happens)

    def _weight(self, element: Element) -> Weight:
        expression = self._source.expression(element)
        if isinstance(expression, Number) and expression.form == "float":
            if not 0.0 <= expression.number <= 1.0:
                element.fail(f"probability {expression.number!r} is outside [0, 1]")
            return Weight(expression.number)
        return Weight(ExpressionModel(expression, self._definitions, element.location))

    def _when(self, element: Element, rules: tuple[str, ...]) -> tuple[Instruction, ...]:
        if not 2 <= len(element.children) <= 3:
            element.fail(
                "<if> takes a test, the instructions if it holds, and the instructions otherwise"
            )
        test, *arms = element.children
        then, otherwise = (
            tuple(self._instructions(arms[index : index + 1], rules)) for index in (0, 1)
        )
        return self._chosen(test, then, otherwise)

    def _chosen(
        self, test: Element, then: tuple[Instruction, ...], otherwise: tuple[Instruction, ...]
    ) -> tuple[Instruction, ...]:
        """Return the instructions that do `then` where a test holds."""
        if test.tag == "not":
            return self._chosen(test.one_child(), otherwise, then)
        if test.tag == "bool":
            return then if read_bool(test) else otherwise
        if test.tag in ("and", "or") and test.children:
            is_and = test.tag == "and"
            for child in reversed(test.children):
                if is_and:
                    then = self._chosen(child, then, otherwise)
                else:
                    otherwise = self._chosen(child, then, otherwise)
            return then if is_and else otherwise
        in_state: InState | Initiated
        if test.tag == "test-functional-event":
            state = self._source.attribute_name(test, "state")
            in_state = InState(self._source.name(test), state)
        elif test.tag == "test-initiating-event":
            in_state = Initiated(self._source.name(test))
        else:
            test.unexpected(_TESTS)
        return (When(in_state, then, otherwise),)


def _unmarked(place: Place, name: str) -> tuple[Place, Attribute | None]:
    """Return a place without the mark of a name, and the mark."""
    marks = [attribute for attribute in place.attributes if attribute.name == name]
    if len(marks) != 1:
        return place, None
    kept = tuple(attribute for attribute in place.attributes if attribute.name != name)
    return replace(place, attributes=kept), marks[0]


def _initiating(element: Element, name: str, mark: Attribute | None) -> InitiatingEvent:
    """Return an initiating event, with the figure that its mark states."""
    if mark is None:
        return InitiatingEvent(name)
    try:
        return InitiatingEvent(name, float(mark.value), mark.type)
    except ValueError as error:
        element.fail(f"{FREQUENCY_MARK} is '{mark.value}'; give a number of 0 or more ({error})")
