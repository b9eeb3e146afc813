"""Event trees as data: what may follow an initiating event, and how each course of it ends.

Forks over functional events branch into paths; a path collects conditions (the top of a fault
tree happens, or does not), probabilities and settings of house events, and leads to the next
fork, to the end of a sequence, to a branch that others share, or into another event tree.
The vocabulary is that of the Open-PSA Model Exchange Format 2.0d, its event tree layer.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.display import Displayed
from tracerisk.prm.other_models.event_trees.building import built_start
from tracerisk.prm.other_models.event_trees.checks import check_names_of, check_order, check_targets
from tracerisk.prm.other_models.event_trees.elements import Branch, EventSequence, InitiatingEvent
from tracerisk.prm.other_models.event_trees.forest import Forest
from tracerisk.prm.other_models.event_trees.solution import outcome_tree, solve_event_tree

if TYPE_CHECKING:
    from tracerisk.prm.other_models.event_trees.building import Alternatives
    from tracerisk.prm.other_models.event_trees.solution import EventTreeSolution
    from tracerisk.prm.trees.fault_tree import FaultTree


@dataclass(frozen=True, slots=True)
class EventTree(Displayed):
    """An event tree.

    Raises ModelError, naming the element, when a name is used twice or unknown, a fork has no
    path or two of one state, a path forks twice over one functional event or against their
    order, or branches resume each other without end.
    """

    name: str
    """Name of the tree, by which other trees link to it."""
    functional_events: tuple[str, ...]
    """Names of the functional events, in the order in which paths may fork over them."""
    start: Branch
    """Where every course begins."""
    sequences: tuple[EventSequence, ...]
    """Ends of paths, with unique names."""
    branches: tuple[Branch, ...] = ()
    """Branches that several paths share, with unique names."""
    initiating: InitiatingEvent | None = None
    """What begins the course; `None` for certainty, under the name of the tree."""
    _branches: Mapping[str, Branch] = field(init=False, repr=False, compare=False)
    """The branches by name."""
    _sequences: Mapping[str, EventSequence] = field(init=False, repr=False, compare=False)
    """The sequences by name."""

    def __post_init__(self) -> None:
        check_names_of(self)
        object.__setattr__(self, "_branches", {branch.name: branch for branch in self.branches})
        object.__setattr__(
            self, "_sequences", {sequence.name: sequence for sequence in self.sequences}
        )
        check_targets(self)
        check_order(self)

    @classmethod
    def of(
        cls,
        name: str,
        functions: Mapping[str, Alternatives],
        sequences: Mapping[str, Mapping[str, str]],
        *,
        end_states: Mapping[str, str] | None = None,
        initiating: float = 1.0,
        per: str = "",
    ) -> EventTree:
        """Build an event tree from a table of its sequences.

        `functions` gives each functional event, in order, what fails it: a gate or event by its
        name, or a probability or failure model; its states are then `success` and `failure`; or
        a mapping of several states to their probabilities.
        `sequences` gives each sequence the state at each functional event that its path forks
        over; `end_states` names the outcomes of those that share one.
        Raises ModelError when a path is missing or given twice.
        """
        ends = end_states or {}
        for sequence in ends:
            if sequence not in sequences:
                raise ModelError(
                    f"event tree '{name}': an end state is given for '{sequence}', which is not "
                    "a sequence; "
                    f"{one_of(sequences, sequence)}"
                )
        return cls(
            name,
            tuple(functions),
            built_start(name, functions, sequences),
            tuple(EventSequence(sequence, ends.get(sequence, "")) for sequence in sequences),
            initiating=InitiatingEvent(name, initiating, per),
        )

    def branch(self, name: str) -> Branch:
        """Return the branch of a name."""
        return self._branches[name]

    def sequence(self, name: str) -> EventSequence:
        """Return the sequence of a name."""
        return self._sequences[name]

    def solve(
        self,
        trees: Forest | FaultTree | Iterable[FaultTree] = (),
        values: Mapping[str, float] | None = None,
        *,
        mission_time_h: float | None = None,
        linked: Iterable[EventTree] = (),
    ) -> EventTreeSolution:
        """Return the probability of each sequence and outcome, exact to rounding.

        `trees` are the fault trees whose gates and events the conditions name; what bears one
        name in several of them is one gate or event.
        `values` gives parameters their probability, above what their models give for
        `mission_time_h`, [h]; `linked` are the event trees that paths may lead into.
        Raises ModelError when a condition, link or value names what is not there, or a value or
        the mission time is missing; TooLargeError when a sequence outgrows every budget.
        """
        forest = trees if isinstance(trees, Forest) else Forest.of(trees)
        known = {event.parameter for event in forest.events.values()}
        for parameter in values or {}:
            if parameter not in known:
                raise ModelError(
                    f"event tree '{self.name}': a value is given for '{parameter}', which is not "
                    f"a parameter of the fault trees; {one_of(known, parameter)}"
                )
        given = {**forest.values_at(mission_time_h), **(values or {})}
        return solve_event_tree(self, forest, given, mission_time_h, linked)

    def outcome_tree(
        self,
        outcome: str,
        trees: Forest | FaultTree | Iterable[FaultTree],
        *,
        linked: Iterable[EventTree] = (),
    ) -> FaultTree:
        """Return the fault tree whose top is that a course, once begun, ends in an outcome.

        It has the outcome's importances and cut sets; see `solve` for the arguments.
        Raises ModelError when no path ends so, or a path has a probability of its own, which is
        no event.
        """
        forest = trees if isinstance(trees, Forest) else Forest.of(trees)
        return outcome_tree(self, outcome, forest, linked)
