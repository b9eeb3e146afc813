"""Several fault trees over one set of gates and events, and trees made of parts of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypeVar

    _Named = TypeVar("_Named", Gate, BasicEvent, HouseEvent)

Settings = tuple[tuple[str, bool], ...]
"""States of house events that differ from their own, in the order of their names."""
Occurrence = tuple[str, bool, Settings]
"""A gate or event, whether it happens, and the house events set for it."""


@dataclass(frozen=True, slots=True)
class Forest:
    """Gates, basic events and house events that several fault trees share."""

    gates: Mapping[str, Gate]
    """Gates by name."""
    events: Mapping[str, BasicEvent]
    """Basic events by name."""
    houses: Mapping[str, HouseEvent]
    """House events by name."""

    @classmethod
    def of(cls, trees: FaultTree | Iterable[FaultTree]) -> Forest:
        """Join fault trees: what bears one name is one gate or event.

        Raises ModelError when two trees mean different things by one name.
        """
        joined = (trees,) if isinstance(trees, FaultTree) else tuple(trees)
        forest = cls(
            _joined("gate", (gate for tree in joined for gate in tree.gates)),
            _joined("basic event", (event for tree in joined for event in tree.events)),
            _joined("house event", (house for tree in joined for house in tree.houses)),
        )
        kinds: dict[str, str] = {}
        for kind, named in (
            ("gate", forest.gates),
            ("basic event", forest.events),
            ("house event", forest.houses),
        ):
            for name in named:
                if kinds.setdefault(name, kind) != kind:
                    raise ModelError(
                        f"'{name}' names a {kinds[name]} in one fault tree and a {kind} in "
                        "another; "
                        "rename one"
                    )
        return forest

    def __contains__(self, name: object) -> bool:
        return name in self.gates or name in self.events or name in self.houses

    def __iter__(self) -> Iterator[str]:
        yield from self.gates
        yield from self.events
        yield from self.houses

    def tree(self, top: str) -> FaultTree:
        """Return the fault tree of a gate or event.

        Raises ModelError when there is none of that name, or what is below it makes no tree.
        """
        return self.joined((((top, True, ()),),))

    def values_at(self, mission_time_h: float | None) -> dict[str, float]:
        """Return the probability of each parameter whose events have a model; see FaultTree."""
        names = tuple(self.events)
        if not names:
            return {}
        top = "every event"
        while top in self.events:
            top += "'"
        every = FaultTree(top, (Gate(top, GateKind.OR, names),), tuple(self.events.values()))
        return every.values_at(mission_time_h)

    def joined(self, alternatives: Sequence[Sequence[Occurrence]]) -> FaultTree:
        """Return the fault tree whose top happens when all of one alternative does.

        Gates below which a house event is set stand in it once for each setting.
        Raises ModelError when a name is unknown.
        """
        grown = _Growth(self)
        tops = []
        for alternative in alternatives:
            inputs = [grown.occurrence(row) for row in dict.fromkeys(alternative)]
            tops.append(inputs[0] if len(inputs) == 1 else grown.gate(GateKind.AND, inputs))
        top = tops[0] if len(tops) == 1 else grown.gate(GateKind.OR, tops)
        return grown.tree(top)


class _Growth:
    """A fault tree that grows out of a forest's gates."""

    def __init__(self, forest: Forest) -> None:
        self._forest = forest
        self._gates: dict[str, Gate] = {}
        self._events: dict[str, BasicEvent] = {}
        self._houses: dict[str, HouseEvent] = {}
        self._placed: dict[tuple[str, Settings], str] = {}
        self._alike: dict[tuple[str, object], str] = {}

    def occurrence(self, occurrence: Occurrence) -> str:
        name, happens, settings = occurrence
        placed = self._place(name, settings)
        return placed if happens else self.gate(GateKind.NOT, [placed])

    def gate(self, kind: GateKind, inputs: Sequence[str]) -> str:
        name = self._free(f"{kind.value} {len(self._gates) + 1}")
        self._gates[name] = Gate(name, kind, tuple(inputs))
        return name

    def tree(self, top: str) -> FaultTree:
        return FaultTree(
            top,
            tuple(self._gates.values()),
            tuple(self._events.values()),
            tuple(self._houses.values()),
        )

    def _place(self, top: str, settings: Settings) -> str:
        """Bring a gate or event and all below it in; return the name that it has here."""
        stack = [(top, False)]
        open_gates: set[str] = set()
        while stack:
            name, below_done = stack.pop()
            if (name, settings) in self._placed:
                continue
            gate = self._forest.gates.get(name)
            if gate is None:
                self._placed[name, settings] = self._leaf(name, settings)
            elif below_done:
                open_gates.discard(name)
                self._placed[name, settings] = self._gate_under(gate, settings)
            else:
                if name in open_gates:
                    raise ModelError(f"gate '{name}' depends on itself; break the cycle")
                open_gates.add(name)
                stack.append((name, True))
                stack.extend((child, False) for child in reversed(gate.inputs))
        return self._placed[top, settings]

    def _leaf(self, name: str, settings: Settings) -> str:
        if name in self._forest.events:
            self._events[name] = self._forest.events[name]
            return name
        if name not in self._forest.houses:
            raise ModelError(f"'{name}' is not a gate or event; {one_of(self._forest, name)}")
        house = self._forest.houses[name]
        state = dict(settings).get(name, house.state)
        placed = name
        if state != house.state:
            placed = self._named(name, state, ((name, state),))
        self._houses[placed] = HouseEvent(placed, state)
        return placed

    def _gate_under(self, gate: Gate, settings: Settings) -> str:
        inputs = tuple(self._placed[name, settings] for name in gate.inputs)
        placed = gate.name
        if inputs != gate.inputs:
            placed = self._named(gate.name, inputs, settings)
        self._gates[placed] = Gate(placed, gate.kind, inputs, gate.k, gate.most)
        return placed

    def _named(self, name: str, made_of: object, settings: Settings) -> str:
        """Return the name of a part as the settings change it, one for all that do so alike."""
        if (name, made_of) not in self._alike:
            states = ", ".join(f"{house} {str(state).lower()}" for house, state in settings)
            self._alike[name, made_of] = self._free(f"{name} [{states}]")
        return self._alike[name, made_of]

    def _free(self, name: str) -> str:
        while name in self._forest or name in self._gates or name in self._houses:
            name += "'"
        return name


def _joined(kind: str, parts: Iterable[_Named]) -> dict[str, _Named]:
    result: dict[str, _Named] = {}
    for part in parts:
        if result.setdefault(part.name, part) != part:
            raise ModelError(
                f"{kind} '{part.name}' has different definitions in two fault trees; rename one"
            )
    return result
