"""The states that hidden failures add to a model: functions times counts of failed latent units.

A latent unit that fails stays failed until the mission ends, wherever it is used. Units that every
function treats alike make a class; a hidden state counts the failed units of each class.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.hybrid.elements import DONE, FunctionState
from tracerisk.prm.hybrid.hidden.latent_units import LatentPart, latent_parts, without_latent
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.elimination import Pattern
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.spares import SpareGroup

MOST_STATES = 4_000
"""Up to how many states a chain with hidden failures is solved exactly."""
MOST_UNSEEN, MOST_SPARES = 500, 250
"""How many units of a group, and of one with spares, may have failed while it still works."""

Hidden = tuple[int, ...]
"""How many units of each class have failed."""


class Part(NamedTuple):
    """A group of latent units in a function's tree, which fails the function by itself."""

    classes: tuple[int, ...]
    """Numbers of the classes of its units; exactly one for a group with spares."""
    threshold: int
    """Number of failed units that fails the part."""
    spares: SpareGroup | None = None
    """The group with its waiting units; `None` where all units work."""


@dataclass(frozen=True, slots=True)
class Function:
    """A function of the chain: its tree without the latent units, the latent units, and what
    follows."""

    state: FunctionState
    """The function as the model has it."""
    rest: FaultTree
    """Fault tree of the function with its latent units taken to work."""
    parts: tuple[Part, ...]
    """Groups of latent units, any of which fails the function."""
    parameters: Mapping[int, str]
    """Parameter name of the units here, by the number of their class."""
    steps: tuple[tuple[int, float], ...]
    """Functions that may follow, ((number, probability), ...), `done` excluded."""
    done: float
    """Probability that the mission ends well after a visit that did not fail."""

    @property
    def spares(self) -> dict[int, SpareGroup]:
        """The classes that are groups with spares here."""
        return {part.classes[0]: part.spares for part in self.parts if part.spares is not None}


@dataclass(frozen=True)
class HiddenStates:
    """The functions that the entry leads to, and the hidden states in which they are met.

    Each hidden state is a layer of the chain.
    """

    functions: tuple[Function, ...]
    """The functions in the order of the model; their place here is their number."""
    entry: int
    """Number of the function that runs first."""
    classes: tuple[tuple[str, ...], ...]
    """Names of the units in each class, (n_classes, n_units of the class)."""
    hidden: tuple[Hidden, ...]
    """Failed units of each class in each layer, (n_layers, n_classes); fewer failed units
    first, none failed at the start."""
    most: int | None
    """Greatest number of failed units in a layer where not all states fit; else `None`."""
    pattern: Pattern
    """Elimination order of the functions, which all layers share."""
    more: tuple[tuple[int, ...], ...] = field(repr=False)
    """Layer with one more failed unit of each class, -1 where there is none, (n_layers,
    n_classes)."""
    held: tuple[tuple[bool, ...], ...] = field(repr=False)
    """Whether a visit of each function can go on in each layer, (n_functions, n_layers)."""

    @cached_property
    def parts_of(self) -> tuple[tuple[Part, ...], ...]:
        """The different parts, of any function, that each class is in."""
        tables: list[dict[Part, None]] = [{} for _ in self.classes]
        for function in self.functions:
            for part in function.parts:
                for unit_class in part.classes:
                    tables[unit_class][part] = None
        return tuple(map(tuple, tables))

    @cached_property
    def functions_with(self) -> Mapping[str, tuple[int, ...]]:
        """The functions that each parameter is in, by number."""
        table: dict[str, list[int]] = {}
        for number, function in enumerate(self.functions):
            for name in function.state.probabilities:
                table.setdefault(name, []).append(number)
        return {name: tuple(numbers) for name, numbers in table.items()}

    def working(self, layer: int, unit_class: int) -> int:
        """Return how many units of a class have not failed."""
        return len(self.classes[unit_class]) - self.hidden[layer][unit_class]


def hidden_states(model: HybridModel, limit: int = MOST_STATES) -> HiddenStates:
    """Return the model's states with all hidden failures that its missions can meet.

    Where they are more than `limit`, those with the most failed units at once are left out.
    Raises ModelError when a tree cannot carry the latent units, see `latent_parts`.
    """
    reached = set(model.reachable)
    states = [state for state in model.states if state.name in reached]
    latent = set(model.latent)
    parts = [_parts(state, latent) for state in states]
    classes = _classes(states, parts)
    class_of = {unit: number for number, units in enumerate(classes) for unit in units}
    number_of = {state.name: number for number, state in enumerate(states)}
    functions = tuple(
        _function(state, latent_parts, class_of, number_of)
        for state, latent_parts in zip(states, parts, strict=True)
    )
    pattern = Pattern(
        lambda number: f"'{states[number].name}'",
        [[target for target, _ in function.steps] for function in functions],
    )
    entry = number_of[model.entry]
    return states_of(functions, classes, entry, pattern, limit // len(functions))


def states_of(
    functions: tuple[Function, ...],
    classes: tuple[tuple[str, ...], ...],
    entry: int,
    pattern: Pattern,
    limit: int,
) -> HiddenStates:
    """Return functions with their hidden states, of which no more than `limit` are held."""
    hidden, is_whole = _enumerate(functions, classes, limit)
    index = {state: number for number, state in enumerate(hidden)}
    # Functions of the same parts hold the same states.
    held = {
        parts: tuple(survives(parts, state) for state in hidden)
        for parts in {function.parts: None for function in functions}
    }
    return HiddenStates(
        functions=functions,
        entry=entry,
        classes=classes,
        hidden=hidden,
        most=None if is_whole else sum(hidden[-1]),
        pattern=pattern,
        more=tuple(
            tuple(index.get(with_more(state, c), -1) for c in range(len(classes)))
            for state in hidden
        ),
        held=tuple(held[function.parts] for function in functions),
    )


def survives(parts: Sequence[Part], hidden: Hidden) -> bool:
    """Return whether no part has failed."""
    return all(sum(hidden[c] for c in part.classes) < part.threshold for part in parts)


def with_more(hidden: Hidden, unit_class: int, failed: int = 1) -> Hidden:
    """Return what has failed when more units of a class have."""
    return (*hidden[:unit_class], hidden[unit_class] + failed, *hidden[unit_class + 1 :])


def _parts(state: FunctionState, latent: set[str]) -> tuple[LatentPart, ...]:
    if not latent:
        return ()
    try:
        return latent_parts(state.tree, latent, state.spares)
    except ModelError as error:
        raise ModelError(f"state '{state.name}': {error.message}", error.location) from error


def _classes(
    states: Sequence[FunctionState], parts: Sequence[Sequence[LatentPart]]
) -> tuple[tuple[str, ...], ...]:
    """Return the units by class: units of a class share part and parameter in every state."""
    uses: dict[str, list[tuple[int, int, str]]] = {}
    for number, (state, of_state) in enumerate(zip(states, parts, strict=True)):
        if of_state:
            parameters = {event.name: event.parameter for event in state.tree.events}
            for index, part in enumerate(of_state):
                for unit in part.units:
                    uses.setdefault(unit, []).append((number, index, parameters[unit]))
    alike: dict[tuple[tuple[int, int, str], ...], list[str]] = {}
    for unit, use in uses.items():
        alike.setdefault(tuple(use), []).append(unit)
    return tuple(map(tuple, alike.values()))


def _function(
    state: FunctionState,
    parts: Sequence[LatentPart],
    class_of: Mapping[str, int],
    number_of: Mapping[str, int],
) -> Function:
    parameters = {event.name: event.parameter for event in state.tree.events} if parts else {}
    return Function(
        state=state,
        rest=without_latent(state.tree, parts),
        parts=tuple(_part(state, part, class_of) for part in parts),
        parameters={class_of[unit]: parameters[unit] for part in parts for unit in part.units},
        steps=tuple(
            (number_of[step.target], float(step.weight))
            for step in state.next
            if step.weight > 0 and step.target != DONE
        ),
        done=math.fsum(float(step.weight) for step in state.next if step.target == DONE),
    )


def _part(state: FunctionState, part: LatentPart, class_of: Mapping[str, int]) -> Part:
    classes = tuple(dict.fromkeys(class_of[unit] for unit in part.units))
    allowed = MOST_UNSEEN if part.spares is None else MOST_SPARES
    if part.threshold - 1 > allowed:
        raise TooLargeError(
            f"state '{state.name}': of the {len(part.units)} units of '{part.units[0]}' and alike, "
            f"{part.threshold - 1} may have failed while the group works; allowed: {allowed}; "
            "describe fewer, larger units"
        )
    if part.spares is None:
        return Part(classes, part.threshold)
    if len(classes) > 1:
        raise ModelError(
            f"state '{state.name}': units of the group with spares of '{part.units[0]}' appear "
            "without the rest of the group in other states; give the group the same units in "
            "every state"
        )
    units = len(part.units)
    return Part(classes, part.threshold, SpareGroup(units, units - part.threshold + 1, part.spares))


def _enumerate(
    functions: Sequence[Function], classes: Sequence[Sequence[str]], limit: int
) -> tuple[tuple[Hidden, ...], bool]:
    """Return the hidden states that a visit can leave, and whether they are all of them.

    Adding one failed unit at a time finds them all: a visit that survives some failed units also
    survives fewer.
    """
    level: dict[Hidden, None] = {(0,) * len(classes): None}
    found = list(level)
    different = list({function.parts: set(function.parameters) for function in functions}.items())
    while level:
        following: dict[Hidden, None] = {}
        for one in _grown(level, different, classes):
            following[one] = None
            if len(found) + len(following) > limit:
                return tuple(found), False
        found += following
        level = following
    return tuple(found), True


def _grown(
    level: Iterable[Hidden],
    different: Collection[tuple[tuple[Part, ...], set[int]]],
    classes: Sequence[Sequence[str]],
) -> Iterator[Hidden]:
    seen: set[Hidden] = set()
    for state in level:
        for number, units in enumerate(classes):
            more = with_more(state, number)
            if (
                state[number] < len(units)
                and more not in seen
                and any(number in used and survives(parts, more) for parts, used in different)
            ):
                seen.add(more)
                yield more
