"""What an event tree comes to: the probability of each sequence and outcome.

A path is the AND of what it collects, success branches as complements, solved as one fault tree:
exact where branches share basic events (Andrews and Dunnett, "Event-tree analysis using binary
decision diagrams", IEEE Transactions on Reliability 49, 2000).
Paths that exclude each other add up; paths that may overlap are one OR.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.table import Table
from tracerisk.prm.other_models.event_trees.elements import InitiatingEvent
from tracerisk.prm.other_models.event_trees.forest import Forest
from tracerisk.prm.other_models.event_trees.paths import CollectedPath, collected_paths
from tracerisk.prm.trees.fault_tree import FaultTree

if TYPE_CHECKING:
    from tracerisk.prm.other_models.event_trees.event_tree import EventTree

_TOLERANCE = 1e-9

_Choosing: TypeAlias = tuple[CollectedPath, dict[object, object]]


@dataclass(frozen=True, slots=True)
class SequenceFigure:
    """The figures of a sequence."""

    event_tree: str
    """Name of the event tree of the sequence."""
    name: str
    """Name of the sequence."""
    end_state: str
    """Name of the outcome."""
    probability: float
    """Probability given the initiating event."""
    value: float
    """Probability or frequency with the initiating event, in the unit of the latter."""


@dataclass(frozen=True, slots=True)
class EventTreeSolution:
    """The figures of an event tree."""

    event_tree: str
    """Name of the event tree."""
    initiating: InitiatingEvent
    """What began the course."""
    sequences: tuple[SequenceFigure, ...]
    """Figures of the sequences, in the order in which paths reach them."""

    @property
    def outcomes(self) -> dict[str, float]:
        """The value of each end state: the sum over its sequences."""
        parts: dict[str, list[float]] = {}
        for sequence in self.sequences:
            parts.setdefault(sequence.end_state, []).append(sequence.value)
        return {end_state: math.fsum(values) for end_state, values in parts.items()}

    @property
    def total(self) -> float:
        """What the probabilities of the sequences, given the initiating event, sum to.

        It is one if the paths of every fork exclude each other and leave nothing out.
        """
        return math.fsum(sequence.probability for sequence in self.sequences)

    @property
    def findings(self) -> tuple[str, ...]:
        """What a user should look at."""
        if abs(self.total - 1.0) <= _TOLERANCE:
            return ()
        return (
            f"the sequences of '{self.event_tree}' sum to {self.total:.6g} of the initiating "
            "event, not 1: the paths of a fork overlap, or do not cover all cases",
        )

    def _repr_html_(self) -> str:
        from html import escape

        unit = f" per {self.initiating.per}" if self.initiating.per else ""
        outcomes = "".join(
            f"<li>{escape(name)}: {value:.6g}{escape(unit)}</li>"
            for name, value in self.outcomes.items()
        )
        notes = "".join(f"<p>{escape(note)}</p>" for note in self.findings)
        return f"<ul>{outcomes}</ul>{Table(self.sequences)._repr_html_()}{notes}"

    def __getitem__(self, sequence: str) -> float:
        """Return the value of a sequence, summed where linked trees share the name."""
        values = [
            sequence_figure.value
            for sequence_figure in self.sequences
            if sequence_figure.name == sequence
        ]
        if not values:
            names = (sequence_figure.name for sequence_figure in self.sequences)
            raise ModelError(f"'{sequence}' is not a sequence; {one_of(names, sequence)}")
        return math.fsum(values)


def solve_event_tree(
    tree: EventTree,
    forest: Forest,
    values: Mapping[str, float],
    mission_time_h: float | None = None,
    linked: Iterable[EventTree] = (),
) -> EventTreeSolution:
    """Solve an event tree over the gates and events of a forest; see EventTree.solve."""
    initiating = tree.initiating or InitiatingEvent(tree.name)
    courses: dict[tuple[str, str], list[CollectedPath]] = {}
    for path in collected_paths(tree, linked, initiating.name):
        _check_names(path, forest)
        courses.setdefault((path.event_tree, path.sequence), []).append(path)
    figures = []
    for (name, sequence), paths in courses.items():
        probability = math.fsum(
            _probability(group, forest, values, mission_time_h) for group in _overlapping(paths)
        )
        value = initiating.value * probability
        figures.append(SequenceFigure(name, sequence, paths[0].end_state, probability, value))
    return EventTreeSolution(tree.name, initiating, tuple(figures))


def outcome_tree(
    tree: EventTree, outcome: str, forest: Forest, linked: Iterable[EventTree] = ()
) -> FaultTree:
    """Return the fault tree of an outcome; see EventTree.outcome_tree."""
    initiating = tree.initiating or InitiatingEvent(tree.name)
    paths = list(collected_paths(tree, linked, initiating.name))
    ending = [path for path in paths if path.end_state == outcome]
    if not ending:
        outcomes = {path.end_state for path in paths}
        raise ModelError(
            f"event tree '{tree.name}': no path ends in '{outcome}'; {one_of(outcomes, outcome)}"
        )
    for path in ending:
        _check_names(path, forest)
        where = f"event tree '{path.event_tree}': sequence '{path.sequence}'"
        if path.weights:
            raise ModelError(
                f"{where}: a path states a probability, which is not an event; give a gate or "
                "event instead"
            )
        if not path.occurrences:
            raise ModelError(f"{where}: a path has no condition; its outcome is certain")
    return forest.joined([path.occurrences for path in ending])


def _check_names(path: CollectedPath, forest: Forest) -> None:
    where = f"event tree '{path.event_tree}': sequence '{path.sequence}'"
    for name, _, settings in path.occurrences:
        if name not in forest:
            raise ModelError(
                f"{where}: '{name}' is not a gate or event of the fault trees; "
                f"{one_of(forest, name)}"
            )
        for house, _ in settings:
            if house not in forest.houses:
                raise ModelError(
                    f"{where}: '{house}' is set, but is not a house event; "
                    f"{one_of(forest.houses, house)}"
                )


def _overlapping(paths: Sequence[CollectedPath]) -> list[list[CollectedPath]]:
    """Part the paths into groups; paths of different groups exclude each other."""
    separate: list[list[CollectedPath]] = []
    waiting = [[(path, path.choices) for path in paths]]
    while waiting:
        group = waiting.pop()
        parts = _parted(group)
        if len(parts) > 1:
            waiting.extend(reversed(parts))
        else:
            separate.extend(_compared(group))
    return separate


def _parted(group: list[_Choosing]) -> list[list[_Choosing]]:
    """Return the paths by their value of a key that all of them have, if they differ in one."""
    for key in group[0][1]:
        parts: dict[object, list[_Choosing]] = {}
        for path, choices in group:
            if key not in choices:
                break
            parts.setdefault(choices[key], []).append((path, choices))
        else:
            if len(parts) > 1:
                return list(parts.values())
    return [group]


def _compared(group: list[_Choosing]) -> list[list[CollectedPath]]:
    """Return the paths in groups, each path compared with all others."""
    groups: list[list[_Choosing]] = []
    for path, choices in group:
        apart, joined = [], [(path, choices)]
        for other in groups:
            if all(_exclude(choices, others) for _, others in other):
                apart.append(other)
            else:
                joined = other + joined
        groups = [*apart, joined]
    return [[path for path, _ in pairs] for pairs in groups]


def _exclude(choices: Mapping[object, object], others: Mapping[object, object]) -> bool:
    return any(choices.get(key, value) != value for key, value in others.items())


def _probability(
    paths: Sequence[CollectedPath],
    forest: Forest,
    values: Mapping[str, float],
    mission_time_h: float | None,
) -> float:
    """Return the probability that one of the paths is taken, given the initiating event."""
    first = paths[0]
    where = f"event tree '{first.event_tree}': sequence '{first.sequence}'"
    try:
        weight = first.weight(mission_time_h)
        if any(path.weight(mission_time_h) != weight for path in paths[1:]):
            raise ModelError(
                "its paths have probabilities but are not mutually exclusive; give each path of "
                "a fork a probability, or a condition and its complement"
            )
        # A path without conditions is always taken, and with it the OR of all.
        if not all(path.occurrences for path in paths):
            return weight
        tree = forest.joined([path.occurrences for path in paths])
        return weight * tree.probability(values).p
    except ModelError as error:
        raise type(error)(f"{where}: {error.message}", error.location) from error
