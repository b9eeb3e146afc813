"""A mission of functions as an event tree: each visit is a functional event, which fails or not."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from tracerisk.errors import TooLargeError
from tracerisk.prm.hybrid.elements import FunctionState
from tracerisk.prm.hybrid.fates.resolved import leads_back
from tracerisk.prm.hybrid.fixed_cycles import Passage, counted_passage
from tracerisk.prm.hybrid.hidden.hidden_states import hidden_states
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    EventSequence,
    Fork,
    InitiatingEvent,
    Path,
    Target,
)
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.expressions import Number
from tracerisk.prm.other_models.formats.conversion import logic_of_functions, with_a_gate
from tracerisk.prm.other_models.logic.mission_parts import EventTreeDefinition
from tracerisk.prm.other_models.logic.model import (
    Container,
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    LogicModel,
    Place,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind

MOST_VISITS = 100
"""How many visits an event tree may have."""
MISSION = "mission"


def logic_of_mission(model: HybridModel) -> LogicModel | None:
    """Return the fault trees of a model's functions and an event tree of its mission.

    A visit that is the only one of its function, and without units that may have failed before,
    has the function's fault tree; each other has one of its own, in which such a unit has failed
    if it did in this visit or an earlier one.
    `None` where the mission is no sequence of at most `MOST_VISITS` visits: it branches, goes round
    as chance has it, goes back after a failure, or has spares.
    Raises ModelError where no function has a component.
    """
    logic = logic_of_functions(model)
    visits = _visits(model)
    if visits is None:
        return None
    counts = Counter(state.name for state in visits)
    unrolled = _Unrolled(model)
    for state in visits:
        if state.tree.events:
            unrolled.add(state, is_only=counts[state.name] == 1)
    return replace(
        logic,
        gates=(*logic.gates, *unrolled.gates),
        events=(*logic.events, *unrolled.events),
        houses=(*logic.houses, *unrolled.houses),
        containers=(*logic.containers, *unrolled.containers),
        event_trees=(EventTreeDefinition(unrolled.event_tree()),),
    )


def _visits(model: HybridModel) -> list[FunctionState] | None:
    """Return the functions in the order of a mission's visits; `None` where it is not fixed."""
    if any(state.spares for state in model.states) or leads_back(model):
        return None
    if model.has_cycle and not model.counted:
        return None
    try:
        states = hidden_states(replace(model, latent=()))
    except TooLargeError:
        return None
    passage = counted_passage(states)
    numbers = None if passage is None else _in_order(passage)
    return None if numbers is None else [states.functions[number].state for number in numbers]


def _in_order(passage: Passage) -> list[int] | None:
    order: list[int] = []
    for item in passage:
        inner: list[int] | None = [item] if isinstance(item, int) else None
        rounds = 1
        if not isinstance(item, int) and item.body is not None:
            inner, rounds = _in_order(item.body), item.rounds
        if inner is None or len(order) + rounds * len(inner) > MOST_VISITS:
            return None
        order += inner * rounds
    return order


class _Unrolled:
    """The visits of a mission so far."""

    def __init__(self, model: HybridModel) -> None:
        self._latent = frozenset(model.latent)
        self._ends = model.failure_states
        self._failed: dict[str, list[str]] = {}
        self._visited: Counter[str] = Counter()
        self._tops: list[tuple[str, str, str]] = []
        self.gates: list[GateDefinition] = []
        self.events: list[EventDefinition] = []
        self.houses: list[HouseDefinition] = []
        self.containers: list[Container] = []

    def add(self, state: FunctionState, *, is_only: bool) -> None:
        """Add the next visit."""
        name, tree = state.name, with_a_gate(state.tree)
        self._visited[name] += 1
        hidden = [event.name for event in tree.events if event.name in self._latent]
        if is_only and not hidden:
            self._tops.append((name, f"{name}.{tree.top}", self._ends[name]))
            return
        home = f"{name} visit {self._visited[name]}"
        self._tops.append((home, f"{home}.{tree.top}", self._ends[name]))
        place = Place(home)
        self.containers.append(Container(home))
        for gate in reversed(tree.upwards):
            inputs = tuple(f"{home}.{text}" for text in gate.inputs)
            self.gates.append(
                GateDefinition(replace(gate, name=f"{home}.{gate.name}", inputs=inputs), place)
            )
        for event in tree.events:
            figure = Number(state.probabilities[event.parameter])
            full = f"{home}.{event.name}"
            if event.name in hidden:
                failed = self._failed.setdefault(event.name, [])
                failed.append(f"{full} now")
                either = Gate(full, GateKind.OR, tuple(failed))
                self.gates.append(GateDefinition(either, place))
                full = failed[-1]
            self.events.append(EventDefinition(full, figure, place))
        self.houses += [
            HouseDefinition(HouseEvent(f"{home}.{house.name}", house.state), place)
            for house in tree.houses
        ]

    def event_tree(self) -> EventTree:
        """Return the event tree of the visits."""
        sequences = [EventSequence(f"{home} fails", end) for home, _, end in self._tops]
        sequences.append(EventSequence("done", "done"))
        target: Target = End("done")
        for (home, top, _), sequence in reversed(list(zip(self._tops, sequences, strict=False))):
            fails = Path("failure", End(sequence.name), (Condition(top, True),))
            target = Fork(home, (fails, Path("success", target, (Condition(top, False),))))
        return EventTree(
            MISSION,
            tuple(home for home, _, _ in self._tops),
            Branch(target),
            tuple(sequences),
            initiating=InitiatingEvent(MISSION),
        )
