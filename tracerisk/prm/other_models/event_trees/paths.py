"""The paths of an event tree, each with all that it collects on its way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.errors import ModelError, TooLargeError, one_of
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.event_trees.elements import (
    Condition,
    End,
    Fork,
    Initiated,
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
from tracerisk.prm.other_models.event_trees.forest import Occurrence, Settings

if TYPE_CHECKING:
    from tracerisk.prm.other_models.event_trees.event_tree import EventTree

_MOST_PATHS = 100_000


class Taken(NamedTuple):
    """A state that a path takes at the fork over a functional event."""

    event_tree: str
    """Name of the event tree of the fork."""
    functional_event: str
    """Name of the functional event."""
    state: str
    """Name of the state taken."""


@dataclass(frozen=True, slots=True)
class CollectedPath:
    """One course from the initiating event to an end, with all that it collected."""

    event_tree: str
    """Name of the event tree in which the path ends."""
    sequence: str
    """Name of the sequence that ends it."""
    end_state: str
    """Name of the outcome."""
    states: tuple[Taken, ...]
    """States taken at the forks, in order."""
    occurrences: tuple[Occurrence, ...]
    """Gates and events that must happen, or must not, each once."""
    weights: tuple[tuple[Taken | None, Weight], ...]
    """Probabilities on the path, each with the state of the fork that gave it; `None` for one
    collected elsewhere."""

    def weight(self, mission_time_h: float | None) -> float:
        """Return the product of the probabilities that the path collected.

        Raises ModelError when one is outside [0, 1], or needs a mission time and has none, [h].
        """
        product = 1.0
        for _, weight in self.weights:
            if isinstance(weight.value, int | float):
                pair = Probability.of(weight.value)
            elif mission_time_h is None:
                raise ModelError("a probability depends on the mission time; give mission_time_h")
            else:
                pair = weight.value.probability(mission_time_h)
            product *= pair.q if weight.complement else pair.p
        return product

    @property
    def choices(self) -> dict[object, object]:
        """What the path needs, by key: paths with different values of one key exclude each other.

        Keys are gates and events under their settings of house events, and forks whose paths
        have probabilities.
        """
        table: dict[object, object] = {
            (name, houses): happens for name, happens, houses in self.occurrences
        }
        table.update((taken[:2], taken.state) for taken, _ in self.weights if taken)
        return table


def collected_paths(
    tree: EventTree, linked: Iterable[EventTree] = (), initiating_event: str = ""
) -> Iterator[CollectedPath]:
    """Yield the paths of an event tree and of those it leads into, from the top down.

    Raises ModelError when a link leads to no tree or back into one it came from, TooLargeError
    beyond 100,000 paths.
    """
    walk = _Walk(
        {event_tree.name: event_tree for event_tree in (tree, *linked)},
        initiating_event or tree.name,
    )
    if _path_count(tree, walk.trees) > _MOST_PATHS:
        raise TooLargeError(
            f"event tree '{tree.name}' has more than {_MOST_PATHS} paths; "
            "split it into trees of fewer functional events"
        )
    begun = _Course(tree, (tree.name,)).following(tree.start.instructions, walk)
    waiting: list[tuple[Target, _Course]] = [(tree.start.target, begun)]
    while waiting:
        target, course = waiting.pop()
        match target:
            case End(name):
                yield course.ended(name, walk)
            case Fork(_, paths):
                waiting.extend(
                    (path.target, course.taking(target, path, walk)) for path in reversed(paths)
                )
            case Resume(name):
                branch = course.tree.branch(name)
                waiting.append((branch.target, course.following(branch.instructions, walk)))
            case Link(name):
                entered = course.entering(name, walk)
                waiting.append((entered.tree.start.target, entered))


def _path_count(tree: EventTree, trees: Mapping[str, EventTree]) -> int:
    """Return how many paths a tree has; one that leads to no tree, or back, counts as one."""
    counts: dict[tuple[str, str], int] = {}

    def of(tree: EventTree, target: Target) -> int:
        match target:
            case Fork(_, paths):
                return sum(of(tree, path.target) for path in paths)
            case Resume(name):
                return once((tree.name, name), tree, tree.branch(name).target)
            case Link(name) if name in trees:
                return once((name, ""), trees[name], trees[name].start.target)
        return 1

    def once(key: tuple[str, str], tree: EventTree, target: Target) -> int:
        if key not in counts:
            counts[key] = 1
            counts[key] = of(tree, target)
        return counts[key]

    return of(tree, tree.start.target)


@dataclass(frozen=True, slots=True)
class _Walk:
    """What all courses through event trees have in common."""

    trees: Mapping[str, EventTree]
    """Event trees that a path may enter, by name."""
    initiating_event: str
    """Name of the initiating event that began the course."""

    def holds(self, test: InState | Initiated, course: _Course) -> bool:
        if isinstance(test, Initiated):
            return test.initiating_event == self.initiating_event
        return (course.tree.name, test.functional_event, test.state) in course.states


@dataclass(frozen=True, slots=True)
class _Course:
    """How far a path has come."""

    tree: EventTree
    """The event tree in which the path is."""
    entered: tuple[str, ...]
    """Names of the event trees entered so far, from the first."""
    states: tuple[Taken, ...] = ()
    """States taken at the forks so far."""
    occurrences: tuple[Occurrence, ...] = ()
    """Gates and events that must happen, or must not, so far."""
    weights: tuple[tuple[Taken | None, Weight], ...] = ()
    """Probabilities so far, each with the state of the fork that gave it, or `None`."""
    settings: Settings = ()
    """House events set so far, by name."""

    def taking(self, fork: Fork, path: Path, walk: _Walk) -> _Course:
        taken = Taken(self.tree.name, fork.functional_event, path.state)
        return replace(self, states=(*self.states, taken)).following(path.instructions, walk, taken)

    def following(
        self, instructions: Sequence[Instruction], walk: _Walk, taken: Taken | None = None
    ) -> _Course:
        course = self
        for instruction in instructions:
            match instruction:
                case Condition(node, happens):
                    occurrence = (node, happens, course.settings)
                    course = replace(course, occurrences=(*course.occurrences, occurrence))
                case Weight():
                    course = replace(course, weights=(*course.weights, (taken, instruction)))
                case SetHouse(house, state):
                    settings = {**dict(course.settings), house: state}
                    course = replace(course, settings=tuple(sorted(settings.items())))
                case When(test, then, otherwise):
                    chosen = then if walk.holds(test, course) else otherwise
                    course = course.following(chosen, walk, taken)
        return course

    def entering(self, name: str, walk: _Walk) -> _Course:
        if name not in walk.trees:
            raise ModelError(
                f"event tree '{self.tree.name}': a path links to the event tree '{name}', which "
                f"is missing; {one_of(walk.trees, name)}"
            )
        if name in self.entered:
            raise ModelError(
                f"event tree '{name}' links back to itself by {' > '.join(self.entered)}; "
                "break the cycle"
            )
        start = walk.trees[name].start
        entered = replace(self, tree=walk.trees[name], entered=(*self.entered, name))
        return entered.following(start.instructions, walk)

    def ended(self, name: str, walk: _Walk) -> CollectedPath:
        sequence = self.tree.sequence(name)
        course = self.following(sequence.instructions, walk)
        return CollectedPath(
            self.tree.name,
            name,
            sequence.end_state,
            course.states,
            tuple(dict.fromkeys(course.occurrences)),
            course.weights,
        )
