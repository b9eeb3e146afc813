"""The states that hidden failures add to a model: functions times counts of failed latent units.

A latent unit that fails stays failed until the mission ends, wherever it is used. Units that every
function treats alike make a class; a hidden state counts the failed units of each class.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tracerisk.errors import ModelError
from tracerisk.prm.elimination import Pattern
from tracerisk.prm.fault_tree import FaultTree
from tracerisk.prm.hybrid import DONE, FunctionState, HybridModel
from tracerisk.prm.latent_units import LatentPart, latent_parts, without_latent

MOST_STATES = 20_000
"""Up to how many states a chain with hidden failures is solved exactly."""

Hidden = tuple[int, ...]
"""How many units of each class have failed."""


@dataclass(frozen=True, slots=True)
class Part:
    """The classes of a part of a function's tree, `threshold` failed units of which fail it."""

    classes: tuple[int, ...]
    threshold: int


@dataclass(frozen=True, slots=True)
class Function:
    """A function of the chain: its tree less the latent units, these, and what follows.

    `parameters` gives each class that the tree has the parameter of its units there.
    """

    state: FunctionState
    rest: FaultTree
    parts: tuple[Part, ...]
    parameters: Mapping[int, str]
    steps: tuple[tuple[int, float], ...]
    done: float

    def survives(self, hidden: Hidden) -> bool:
        """Return whether a visit goes on with so many failed units."""
        return all(sum(hidden[c] for c in part.classes) < part.threshold for part in self.parts)


@dataclass(frozen=True, slots=True)
class HiddenStates:
    """The functions that the entry leads to, and the hidden states in which they are met.

    `hidden` comes with fewer failed units first, the state without any at the start; `most` is
    the greatest number of failed units among them where not all states fit, else `None`.
    """

    functions: tuple[Function, ...]
    entry: int
    classes: tuple[tuple[str, ...], ...]
    hidden: tuple[Hidden, ...]
    most: int | None
    pattern: Pattern
    index: Mapping[Hidden, int] = field(repr=False)

    def is_held(self, function: Function, hidden: Hidden) -> bool:
        """Return whether a visit goes on and the state that it leaves is one of `hidden`."""
        return function.survives(hidden) and (self.most is None or sum(hidden) <= self.most)

    def with_one_more(self, hidden: Hidden, unit_class: int) -> Hidden:
        """Return the state with one more failed unit of a class."""
        return (*hidden[:unit_class], hidden[unit_class] + 1, *hidden[unit_class + 1 :])


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
        _function(state, found, class_of, number_of)
        for state, found in zip(states, parts, strict=True)
    )
    hidden, is_whole = _enumerate(functions, classes, limit // len(functions))
    return HiddenStates(
        functions=functions,
        entry=number_of[model.entry],
        classes=classes,
        hidden=hidden,
        most=None if is_whole else sum(hidden[-1]),
        pattern=Pattern(
            [state.name for state in states],
            [[target for target, _ in function.steps] for function in functions],
        ),
        index={state: number for number, state in enumerate(hidden)},
    )


def _parts(state: FunctionState, latent: set[str]) -> tuple[LatentPart, ...]:
    if not latent:
        return ()
    try:
        return latent_parts(state.tree, latent)
    except ModelError as error:
        raise ModelError(f"state '{state.name}': {error.message}", error.location) from error


def _classes(
    states: Sequence[FunctionState], parts: Sequence[Sequence[LatentPart]]
) -> tuple[tuple[str, ...], ...]:
    """Return the units in classes: in every state of one part, with one parameter."""
    uses: dict[str, list[tuple[int, int, str]]] = {}
    for number, (state, found) in enumerate(zip(states, parts, strict=True)):
        if found:
            parameters = {event.name: event.parameter for event in state.tree.events}
            for index, part in enumerate(found):
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
        parts=tuple(
            Part(tuple(dict.fromkeys(class_of[unit] for unit in part.units)), part.threshold)
            for part in parts
        ),
        parameters={class_of[unit]: parameters[unit] for part in parts for unit in part.units},
        steps=tuple(
            (number_of[step.target], float(step.weight))
            for step in state.next
            if step.weight > 0 and step.target != DONE
        ),
        done=sum(float(step.weight) for step in state.next if step.target == DONE),
    )


def _enumerate(
    functions: Sequence[Function], classes: Sequence[Sequence[str]], limit: int
) -> tuple[tuple[Hidden, ...], bool]:
    """Return the hidden states that a visit can leave, and whether they are all of them.

    One more failed unit at a time finds them all, for with more units failed no visit survives
    that would not with fewer.
    """
    level: dict[Hidden, None] = {(0,) * len(classes): None}
    found = list(level)
    # Functions of the same parts leave the same states.
    different = {function.parts: function for function in functions if function.parts}
    while level:
        following: dict[Hidden, None] = {}
        for one in _grown(level, different.values(), classes):
            following[one] = None
            if len(found) + len(following) > limit:
                return tuple(found), False
        found += following
        level = following
    return tuple(found), True


def _grown(
    level: Mapping[Hidden, None],
    functions: Collection[Function],
    classes: Sequence[Sequence[str]],
) -> Iterator[Hidden]:
    used = [(function, set(function.parameters)) for function in functions]
    seen: set[Hidden] = set()
    for state in level:
        for number, units in enumerate(classes):
            if state[number] < len(units):
                more = (*state[:number], state[number] + 1, *state[number + 1 :])
                if more not in seen and any(
                    number in those and function.survives(more) for function, those in used
                ):
                    seen.add(more)
                    yield more
