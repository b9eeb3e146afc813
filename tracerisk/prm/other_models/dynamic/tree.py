"""Dynamic fault trees, and the static trees that they become."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.display import AsGraph
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.numbers.quantities import check_mission_time
from tracerisk.prm.other_models.dynamic.building import tree_parts
from tracerisk.prm.other_models.dynamic.elements import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    Restriction,
)
from tracerisk.prm.other_models.dynamic.group_model import DynamicGroup
from tracerisk.prm.other_models.dynamic.groups import find_groups
from tracerisk.prm.other_models.dynamic.layout import AnyGate
from tracerisk.prm.other_models.dynamic.solution import DynamicSolution
from tracerisk.prm.trees.events import BasicEvent, FailureModel
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, check_gate

if TYPE_CHECKING:
    from tracerisk.prm.other_models.dynamic.building import Formula
    from tracerisk.prm.other_models.dynamic.solution import DynamicSolution

STATE_LIMIT = 100_000
"""The most states of one group; some twenty seconds of work."""


@dataclass(frozen=True, slots=True)
class DynamicTree(AsGraph):
    """A fault tree with static and dynamic gates, dependencies and restrictions.

    What a dynamic gate, a dependency or a restriction touches is solved by a Markov model, the
    smallest part of the tree that shares nothing with the rest; the tree that is left is static,
    and each such part one basic event of it.
    Raises ModelError when a name is used twice, an input is unknown, a gate stands above itself,
    something is neither below the top nor tied to what is, a dependent is no event, or a gate does
    not fit its kind.
    """

    top: str
    """Name of the gate or event that is the top event."""
    gates: tuple[AnyGate, ...]
    """Static and dynamic gates, in any order."""
    events: tuple[DynamicEvent, ...]
    """Basic events."""
    dependencies: tuple[Dependency, ...] = ()
    """Dependencies, in the order in which they act at one instant."""
    restrictions: tuple[Restriction, ...] = ()
    """Restrictions on what can happen."""
    state_limit: int = STATE_LIMIT
    """Most states of the Markov chain of one group."""
    _upwards: tuple[AnyGate, ...] = field(init=False, repr=False, compare=False)
    """The gates, each after those below it."""

    def __post_init__(self) -> None:
        _check_names(self)
        object.__setattr__(self, "_upwards", _order_upwards(self))

    @classmethod
    def of(
        cls,
        top: str,
        gates: Mapping[str, Formula],
        events: Mapping[str, float | FailureModel | DynamicEvent],
    ) -> DynamicTree:
        """Build a tree from formulas such as `{"pumps": ("spare", "p1", "p2")}`.

        A formula names the kind of a gate, of a dependency (`fdep`, `pdep` with its probability)
        or of a restriction (`seq`, `mutex`), the number of an `atleast`, and the inputs.
        `events` gives each event a probability, a failure model, or a `DynamicEvent`, which has a
        dormancy too.
        Raises ModelError, naming the element, when they make no tree.
        """
        return cls(top, *tree_parts(gates, events))

    @property
    def upwards(self) -> tuple[AnyGate, ...]:
        """The gates, each after those below it."""
        return self._upwards

    @property
    def ties(self) -> tuple[Dependency | Restriction, ...]:
        """The dependencies, then the restrictions: what ties elements together from the side."""
        return (*self.dependencies, *self.restrictions)

    def static_tree(self) -> FaultTree:
        """Return the static tree in which each dynamic group is one basic event.

        The event has the name of the group's top, its model is a `DynamicGroup`.
        Raises ModelError when a group holds what has no meaning in a Markov model.
        """
        groups = find_groups(self)
        replaced = {*groups, *(name for members in groups.values() for name in members)}
        gates = tuple(
            gate
            for gate in reversed(self._upwards)
            if isinstance(gate, Gate) and gate.name not in replaced
        )
        events = [
            BasicEvent(event.name, model=event.model)
            for event in self.events
            if event.name not in replaced
        ]
        events += [
            BasicEvent(top, model=DynamicGroup(_part(self, top, members)))
            for top, members in groups.items()
        ]
        return FaultTree(self.top, gates, tuple(events))

    def solve(self, *, mission_time_h: float) -> DynamicSolution:
        """Solve the tree for a mission, [h]: its top's probability, and each event's importance.

        Raises as `probability` does.
        """
        return DynamicSolution(self, mission_time_h, self.probability(mission_time_h))

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability that the top happens within the mission, [h].

        Raises TooLargeError when a group has too many states, ModelError as `static_tree` does
        and for a mission time that is not a number of 0 or more.
        """
        check_mission_time(mission_time_h)
        tree = self.static_tree()
        if not tree.gates:
            # The whole tree is one event: its pair needs no rounding to one number.
            model = tree.events[0].model
            if model is not None:
                return model.probability(mission_time_h)
        return tree.probability(tree.values_at(mission_time_h))


def _part(tree: DynamicTree, top: str, members: Sequence[str]) -> DynamicTree:
    inside = {top, *members}
    return DynamicTree(
        top,
        tuple(gate for gate in tree.gates if gate.name in inside),
        tuple(event for event in tree.events if event.name in inside),
        tuple(tie for tie in tree.dependencies if inside.issuperset(tie.inputs)),
        tuple(tie for tie in tree.restrictions if inside.issuperset(tie.inputs)),
        tree.state_limit,
    )


def _check_names(tree: DynamicTree) -> None:
    elements = {element.name for element in (*tree.gates, *tree.events)}
    seen: set[str] = set()
    for named in (*tree.gates, *tree.events, *tree.ties):
        if named.name in seen:
            raise ModelError(
                f"'{named.name}' names two gates, events, dependencies or restrictions; rename one"
            )
        if not named.name or not named.name.isprintable():
            raise ModelError(f"{named.name!r} names a gate or event; it needs printable characters")
        seen.add(named.name)
    if tree.top not in elements:
        raise ModelError(f"top '{tree.top}' is not a gate or event; {one_of(elements, tree.top)}")
    for user in (*tree.gates, *tree.ties):
        for name in user.inputs:
            if name not in elements:
                raise ModelError(
                    f"'{user.name}': input '{name}' is not a gate or event; "
                    f"{one_of(elements, name)}"
                )
        if isinstance(user, Gate):
            check_gate(user)
    events = {event.name for event in tree.events}
    for dependency in tree.dependencies:
        for name in dependency.dependents:
            if name not in events:
                raise ModelError(
                    f"dependency '{dependency.name}': dependent '{name}' is a gate; make its "
                    "events dependent"
                )


def _order_upwards(tree: DynamicTree) -> tuple[AnyGate, ...]:
    """Return the gates, each after those below it; iterative, for trees of any depth."""
    gates = {gate.name: gate for gate in tree.gates}
    order: list[AnyGate] = []
    open_gates: set[str] = set()
    seen: set[str] = set()
    waiting = list(tree.ties)
    stack = [(tree.top, False)]
    while stack:
        name, below_done = stack.pop()
        gate = gates.get(name)
        if below_done and gate is not None:
            open_gates.discard(name)
            order.append(gate)
        elif name in open_gates:
            raise ModelError(f"gate '{name}' depends on itself; break the cycle")
        elif name not in seen:
            seen.add(name)
            if gate is not None:
                open_gates.add(name)
                stack.append((name, True))
                stack.extend((child, False) for child in reversed(gate.inputs))
        if not stack:
            # What is tied to something below the top belongs to the tree, too.
            tied = [tie for tie in waiting if not seen.isdisjoint(tie.inputs)]
            waiting = [tie for tie in waiting if seen.isdisjoint(tie.inputs)]
            stack = [(name, False) for tie in reversed(tied) for name in reversed(tie.inputs)]
    loose = sorted({one.name for one in (*tree.gates, *tree.events, *waiting)} - seen)
    if loose:
        raise ModelError(
            f"not below the top '{tree.top}': {', '.join(loose)}; connect or remove them"
        )
    return tuple(order)


__all__ = ["STATE_LIMIT", "DynamicGate", "DynamicGroup", "DynamicTree"]
