"""Event trees as elements of Open-PSA."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.event_trees.elements import (
    Condition,
    End,
    EventSequence,
    Fork,
    InState,
    Instruction,
    Link,
    Resume,
    SetHouse,
    Target,
    Weight,
    When,
)
from tracerisk.prm.other_models.expressions import Difference, ExpressionModel, Number
from tracerisk.prm.other_models.formats.open_psa.rewriting import END_STATE_MARK, FREQUENCY_MARK
from tracerisk.prm.other_models.formats.open_psa.stochastic import (
    Node,
    constant_node,
    expression_node,
)
from tracerisk.prm.other_models.formats.open_psa.xml_text import notes
from tracerisk.prm.other_models.logic.mission_parts import EventTreeDefinition
from tracerisk.prm.other_models.logic.model import Attribute, LogicModel, Place

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tracerisk.prm.other_models.formats.open_psa.element_names import Names


def event_tree_nodes(
    model: LogicModel, names: Names, condition: Callable[[str, str], Node]
) -> list[Node]:
    """Return the elements of the event trees and initiating events.

    `condition` gives the formula of a gate, and takes the name that the reader would give to it if
    it is written in place.
    Raises ModelError when Open-PSA cannot hold an event tree.
    """
    nodes = [
        names.node("define-initiating-event", initiating_event.name)
        for initiating_event in model.initiating_events
    ]
    for event_tree in model.event_trees:
        nodes += _TreeWriter(event_tree, names, condition).nodes()
    return nodes


class _TreeWriter:
    """Makes the elements of one event tree."""

    def __init__(
        self, definition: EventTreeDefinition, names: Names, condition: Callable[[str, str], Node]
    ) -> None:
        self._tree = definition.tree
        self._place = definition.place
        self._names = names
        self._formula = condition
        self._notes = {(kind, name): place for kind, name, place in definition.notes}
        self._links: dict[str, str] = {}
        self._conditions = 0

    def nodes(self) -> list[Node]:
        """Return the initiating event, if there is one, and the tree."""
        tree = self._tree
        rows: list[Node] = []
        if tree.initiating is not None:
            begins = {"event-tree": self._names.name(tree.name)}
            place = self._notes.get(("initiating-event", tree.initiating.name), Place())
            if tree.initiating.value != 1.0 or tree.initiating.per:
                value = repr(float(tree.initiating.value))
                place = _marked(place, Attribute(FREQUENCY_MARK, value, tree.initiating.per))
            node = self._names.node
            name = tree.initiating.name
            rows.append(node("define-initiating-event", name, notes(place), **begins))
        body = [self._defined("functional-event", name, []) for name in tree.functional_events]
        sequences = [self._sequence(sequence) for sequence in tree.sequences]
        branches = [
            self._defined("branch", branch.name, self._course(branch.target, branch.instructions))
            for branch in tree.branches
        ]
        start = self._course(tree.start.target, tree.start.instructions)
        sequences += [
            ("define-sequence", {"name": name}, [("event-tree", {"name": linked}, [])])
            for linked, name in self._links.items()
        ]
        body += [*sequences, *branches, ("initial-state", {}, start)]
        body = [*notes(self._place), *body]
        rows.append(self._names.node("define-event-tree", tree.name, body))
        return rows

    def _remarks(self, kind: str, name: str) -> list[Node]:
        return notes(self._notes.get((kind, name), Place()))

    def _defined(self, kind: str, name: str, body: list[Node]) -> Node:
        return self._names.node(f"define-{kind}", name, [*self._remarks(kind, name), *body])

    def _sequence(self, sequence: EventSequence) -> Node:
        place = self._notes.get(("sequence", sequence.name), Place())
        if sequence.end_state != sequence.name:
            place = _marked(place, Attribute(END_STATE_MARK, sequence.end_state))
        body = [*notes(place), *self._instructions(sequence.instructions)]
        return self._names.node("define-sequence", sequence.name, body)

    def _course(self, target: Target, instructions: Sequence[Instruction]) -> list[Node]:
        return [*self._instructions(instructions), self._target(target)]

    def _target(self, target: Target) -> Node:
        if isinstance(target, End):
            return self._names.node("sequence", target.sequence)
        if isinstance(target, Resume):
            return self._names.node("branch", target.branch)
        if isinstance(target, Link):
            linked = self._names.name(target.event_tree)
            name = self._links.setdefault(linked, self._names.name(f"#{target.event_tree}"))
            return "sequence", {"name": name}, []
        assert isinstance(target, Fork)
        paths: list[Node] = [
            (
                "path",
                {"state": self._names.name(path.state)},
                self._course(path.target, path.instructions),
            )
            for path in target.paths
        ]
        return "fork", {"functional-event": self._names.name(target.functional_event)}, paths

    def _instructions(self, instructions: Sequence[Instruction]) -> list[Node]:
        return [self._instruction(instruction) for instruction in instructions]

    def _instruction(self, instruction: Instruction) -> Node:
        if isinstance(instruction, Condition):
            return "collect-formula", {}, [self._condition(instruction)]
        if isinstance(instruction, Weight):
            return "collect-expression", {}, [self._weight(instruction)]
        if isinstance(instruction, SetHouse):
            state = constant_node(instruction.state)
            return self._names.node("set-house-event", instruction.house, [state])
        assert isinstance(instruction, When)
        test = instruction.test
        if isinstance(test, InState):
            held = self._names.name(test.state)
            asked = self._names.node("test-functional-event", test.functional_event, state=held)
        else:
            asked = self._names.node("test-initiating-event", test.initiating_event)
        arms = [self._block(instruction.then)]
        if instruction.otherwise:
            arms.append(self._block(instruction.otherwise))
        return "if", {}, [asked, *arms]

    def _block(self, instructions: Sequence[Instruction]) -> Node:
        nodes = self._instructions(instructions)
        return nodes[0] if len(nodes) == 1 else ("block", {}, nodes)

    def _condition(self, condition: Condition) -> Node:
        expected = f"#{self._tree.name}#{self._conditions + 1}"
        if condition.node == expected:
            self._conditions += 1
        formula = self._formula(condition.node, expected)
        return formula if condition.happens else ("not", {}, [formula])

    def _weight(self, weight: Weight) -> Node:
        value = weight.value
        if isinstance(value, ExpressionModel):
            expression = value.expression
        elif isinstance(value, int | float):
            expression = Number(float(value))
        else:
            raise ModelError(
                f"event tree '{self._tree.name}': Open-PSA cannot express a weight of type "
                f"{type(value).__name__}; give an expression or a number"
            )
        if weight.complement:
            expression = Difference((Number(1.0), expression))
        return expression_node(expression, self._names.parameter)


def _marked(place: Place, mark: Attribute) -> Place:
    return replace(place, attributes=(*place.attributes, mark))
