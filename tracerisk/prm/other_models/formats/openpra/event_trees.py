"""Event trees of OpenPRA: sequences as states of functional events, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.formats.element import Element
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    EventSequence,
    Fork,
    InitiatingEvent,
    Instruction,
    Path,
    Resume,
    Target,
)
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.logic.mission_parts import EventTreeDefinition
from tracerisk.prm.other_models.logic.model import Place

STATES = ("failure", "success", "bypass")
YEARLY = "yr-1"

States = dict[str, tuple[str, Element]]
"""The state of each functional event of a sequence, and where it is stated."""


def read_event_tree(element: Element, tops: Mapping[str, str]) -> EventTreeDefinition:
    """Return an event tree; `tops` gives the top gate of each fault tree.

    A functional event is the fault tree of its name, or that of its `refGate`.
    Raises ModelError, with the path and the place, for what is malformed.
    """
    fields = element.fields(
        {"name", "initiatingEvent"}, optional={"description", "functionalEvents", "sequences"}
    )
    notes: list[tuple[str, str, Place]] = []
    initiating = _read_initiating(fields["initiatingEvent"], notes)
    sequences: list[EventSequence] = []
    stated: list[States] = []
    gates: dict[str, str] = {}
    for item in fields["sequences"].items() if "sequences" in fields else ():
        parts = item.fields(
            {"functionalStates", "endState"}, optional={"name", "frequency", "unit"}
        )
        end = parts["endState"].string()
        name = parts["name"].string() if "name" in parts else end
        sequences.append(EventSequence(name, end))
        stated.append(_read_states(parts["functionalStates"], gates, tops))
    functions = _read_functions(fields, stated, notes)
    if not sequences:
        element.fail("'sequences' are missing; give at least one")
    places = fields["sequences"].items()

    def target(level: int, left: Sequence[int]) -> Target:
        """Return how the sequences `left` part over the functional events from `level` on."""
        if level == len(functions):
            if len(left) > 1:
                places[left[1]].fail(
                    f"has the same states as '{sequences[left[0]].name}'; remove one of them"
                )
            return End(sequences[left[0]].name)
        function = functions[level]
        parted: dict[str, list[int]] = {}
        for index in left:
            state = stated[index].get(function)
            parted.setdefault("bypass" if state is None else state[0], []).append(index)
        if list(parted) == ["bypass"]:
            return target(level + 1, left)
        return Fork(
            function,
            tuple(
                Path(state, target(level + 1, parted[state]), _condition(state, gates[function]))
                for state in STATES
                if state in parted
            ),
        )

    start = Branch(target(0, range(len(sequences))))
    label = fields["description"].string() if "description" in fields else ""
    tree = element.guard(
        lambda: EventTree(
            fields["name"].string(), functions, start, tuple(sequences), initiating=initiating
        )
    )
    return EventTreeDefinition(tree, Place(label=label), tuple(notes))


def _condition(state: str, gate: str) -> tuple[Instruction, ...]:
    return () if state == "bypass" else (Condition(gate, state == "failure"),)


def _read_initiating(element: Element, notes: list[tuple[str, str, Place]]) -> InitiatingEvent:
    fields = element.fields({"name", "frequency"}, optional={"description", "unit"})
    name = fields["name"].string()
    if "description" in fields:
        notes.append(("initiating-event", name, Place(label=fields["description"].string())))
    frequency = fields["frequency"].number()
    per = ""
    if "unit" in fields:
        fields["unit"].choice((YEARLY,))
        per = "year"
    elif frequency > 1.0:
        # Without a unit it may be a probability; this one cannot.
        per = "year"
    return fields["frequency"].guard(lambda: InitiatingEvent(name, frequency, per))


def _read_states(element: Element, gates: dict[str, str], tops: Mapping[str, str]) -> States:
    states: States = {}
    for item in element.items():
        parts = item.fields({"name", "state"}, optional={"refGate"})
        name = parts["name"].string()
        if name in states:
            parts["name"].fail(f"duplicate '{name}' in one sequence; remove one")
        states[name] = (parts["state"].choice(STATES), item)
        where, tree = parts["name"], name
        if "refGate" in parts:
            where = parts["refGate"].fields({"name"})["name"]
            tree = where.string()
        if states[name][0] == "bypass" and tree not in tops:
            continue
        if tree not in tops:
            where.fail(f"'{tree}' is not a fault tree; {one_of(tops, tree)}")
        if gates.setdefault(name, tops[tree]) != tops[tree]:
            where.fail(f"'{name}' names two fault trees; rename one")
    return states


def _read_functions(
    found: dict[str, Element], stated: Sequence[States], notes: list[tuple[str, str, Place]]
) -> tuple[str, ...]:
    """Return the functional events in their order: as defined, else as the sequences have them."""
    used: dict[str, Element] = {}
    for states in stated:
        for name, (_, element) in states.items():
            used.setdefault(name, element)
    if "functionalEvents" not in found:
        return tuple(used)
    functions = []
    for item in found["functionalEvents"].items():
        parts = item.fields({"name"}, optional={"description", "frequency"})
        functions.append(parts["name"].string())
        if "description" in parts:
            label = parts["description"].string()
            notes.append(("functional-event", functions[-1], Place(label=label)))
    for name, element in used.items():
        if name not in functions:
            element.fail(f"'{name}' is not a functional event; {one_of(functions, name)}")
    return tuple(functions)


def event_tree_data(
    definition: EventTreeDefinition, tree_of: Callable[[str], str]
) -> dict[str, Any]:
    """Return an event tree as OpenPRA has it; `tree_of` gives the fault tree of a gate.

    Raises ModelError when OpenPRA cannot hold it.
    """
    tree = definition.tree
    where = f"event tree '{tree.name}'"
    notes = {(kind, name): place.label for kind, name, place in definition.notes}
    initiating = tree.initiating or InitiatingEvent(tree.name)
    begun: dict[str, Any] = {"name": initiating.name, "frequency": initiating.value}
    begun = described(begun, notes.get(("initiating-event", initiating.name), ""))
    if initiating.per not in ("", "year"):
        raise ModelError(
            f"{where}: OpenPRA has frequencies per year only, not per {initiating.per}; convert it"
        )
    if initiating.per:
        begun["unit"] = YEARLY
    functions = [
        described({"name": name}, notes.get(("functional-event", name), ""))
        for name in tree.functional_events
    ]
    sequences = []
    for course in _courses(tree, where):
        states = [
            _state(name, instructions, tree_of, where)
            for name in tree.functional_events
            # The engine looks for the gate of what is bypassed, too.
            if (instructions := course.states.get(name))
        ]
        sequence = tree.sequence(course.sequence)
        collected = {"name": sequence.name, "functionalStates": states}
        sequences.append(collected | {"endState": sequence.end_state})
    return described({"name": tree.name}, definition.place.label) | {
        "initiatingEvent": begun,
        "functionalEvents": functions,
        "sequences": sequences,
    }


def described(data: dict[str, Any], label: str) -> dict[str, Any]:
    """Return the data with a description, where there is one."""
    return data | ({"description": label} if label else {})


def _state(
    name: str,
    instructions: tuple[Instruction, ...],
    tree_of: Callable[[str], str],
    where: str,
) -> dict[str, Any]:
    first = instructions[0]
    if len(instructions) > 1 or not isinstance(first, Condition):
        raise ModelError(
            f"{where}: at '{name}' a path does more than collect one gate, which OpenPRA cannot "
            "express; restructure the tree, or use another format"
        )
    fault_tree = tree_of(first.node)
    data: dict[str, Any] = {"name": name, "state": "failure" if first.happens else "success"}
    if fault_tree != name:
        data["refGate"] = {"name": fault_tree}
    return data


class _Course(NamedTuple):
    """A path through an event tree."""

    sequence: str
    """Name of the sequence that ends it."""
    states: dict[str, tuple[Instruction, ...]]
    """What the path collects at each functional event that it passes, by name."""


def _courses(tree: EventTree, where: str) -> list[_Course]:
    """Return the ways through an event tree, one for each sequence.

    Raises ModelError when one collects what does not belong to a functional event, or a sequence
    ends several ways.
    """
    courses: list[_Course] = []

    def check(instructions: Sequence[Instruction], what: str) -> None:
        if instructions:
            raise ModelError(
                f"{where}: {what} has instructions of its own, which OpenPRA cannot express; "
                "move them into paths"
            )

    def follow(target: Target, states: dict[str, tuple[Instruction, ...]]) -> None:
        if isinstance(target, End):
            check(tree.sequence(target.sequence).instructions, f"sequence '{target.sequence}'")
            if any(course.sequence == target.sequence for course in courses):
                raise ModelError(
                    f"{where}: several paths end in the sequence '{target.sequence}'; "
                    "OpenPRA takes one: give each a sequence, with one end state"
                )
            courses.append(_Course(target.sequence, states))
        elif isinstance(target, Resume):
            branch = tree.branch(target.branch)
            check(branch.instructions, f"branch '{branch.name}'")
            follow(branch.target, states)
        elif isinstance(target, Fork):
            for path in target.paths:
                follow(path.target, {**states, target.functional_event: path.instructions})
        else:
            raise ModelError(
                f"{where}: a path leads into another event tree, which OpenPRA cannot express; "
                "join the two"
            )

    check(tree.start.instructions, "the initial state")
    follow(tree.start.target, {})
    order = {sequence.name: rank for rank, sequence in enumerate(tree.sequences)}
    return sorted(courses, key=lambda course: order[course.sequence])
