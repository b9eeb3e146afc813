"""Fault trees as data, and their exact probability where the events are independent."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.probability import Probability, at_least, deciding


class GateKind(enum.Enum):
    """How a gate joins its inputs."""

    OR = "or"
    AND = "and"
    ATLEAST = "atleast"


@dataclass(frozen=True, slots=True)
class BasicEvent:
    """The failure of one unit; `parameter` names the figure that it shares with others.

    Instances of a component, and the states of a chain, share one parameter.
    """

    name: str
    parameter: str


@dataclass(frozen=True, slots=True)
class Gate:
    """A gate over the gates and events named by `inputs`; `k` for ATLEAST only.

    ATLEAST happens when at least `k` of its inputs do.
    An OR without inputs never happens: a function that leans on no hardware.
    """

    name: str
    kind: GateKind
    inputs: tuple[str, ...]
    k: int | None = None

    @property
    def threshold(self) -> int:
        """The least number of inputs that makes the gate happen."""
        if self.k is not None:
            return self.k
        return 1 if self.kind is GateKind.OR else len(self.inputs)


@dataclass(frozen=True, slots=True)
class FaultTree:
    """A coherent fault tree: named gates over named basic events, `top` one of them.

    Raises ModelError when a name is used twice, an input is unknown, a gate stands above
    itself, a gate or event is not below the top, or a gate's `k` or inputs do not fit its kind.
    """

    top: str
    gates: tuple[Gate, ...]
    events: tuple[BasicEvent, ...]
    _upwards: tuple[Gate, ...] = field(init=False, repr=False, compare=False)
    _shared: Mapping[str, tuple[str, ...]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        names: set[str] = set()
        for name in _names(self):
            if name in names:
                raise ModelError(f"'{name}' names two gates or events; rename one")
            if not name or not name.isprintable():
                raise ModelError(f"{name!r} names a gate or event; it needs printable characters")
            names.add(name)
        if self.top not in names:
            raise ModelError(f"the top '{self.top}' is no gate or event; {one_of(names)}")
        for gate in self.gates:
            _check_gate(gate, names)
        object.__setattr__(self, "_upwards", _order_upwards(self))
        object.__setattr__(self, "_shared", _find_shared(self))

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters of the events, each once, in the order of the events."""
        return tuple(dict.fromkeys(event.parameter for event in self.events))

    @property
    def shared(self) -> Mapping[str, tuple[str, ...]]:
        """The gates and events that feed more than one gate, or one gate twice, with those."""
        return self._shared

    def probability(self, values: Mapping[str, float]) -> Probability:
        """Return the top event's probability, exact to rounding.

        `values` gives each parameter the probability of one event.
        Raises ModelError when a parameter has no value or one outside [0, 1], or when an event
        is shared, for then the closed form of independent inputs does not hold.
        """
        return self._sweep(values)[self.top]

    def sensitivities(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return for each event the derivative of the top's probability by the event's.

        Sums and products of probabilities only: no difference is taken, nothing cancels
        (Birnbaum 1969, "On the importance of different components").
        Raises ModelError as `probability` does.
        """
        nodes = self._sweep(values)
        weights = {self.top: 1.0}
        for gate in reversed(self._upwards):
            inputs = [nodes[name] for name in gate.inputs]
            shares = deciding(gate.threshold, inputs, inputs)
            for name, share in zip(gate.inputs, shares, strict=True):
                weights[name] = weights[gate.name] * share
        return {event.name: weights[event.name] for event in self.events}

    def drop_without(self, parameter: str, values: Mapping[str, float]) -> float:
        """Return how much the top's probability falls when `parameter` is set to zero.

        The difference is taken inside the tree, gate by gate, as a sum of products of
        probabilities: it keeps its relative precision beside a top of any size.
        Raises ModelError as `probability` does.
        """
        high = self._sweep(values)
        low = self._sweep({**values, parameter: 0.0})
        drops = {
            event.name: high[event.name].p if event.parameter == parameter else 0.0
            for event in self.events
        }
        for gate in self._upwards:
            shares = deciding(
                gate.threshold,
                [high[name] for name in gate.inputs],
                [low[name] for name in gate.inputs],
            )
            drops[gate.name] = sum(
                share * drops[name] for name, share in zip(gate.inputs, shares, strict=True)
            )
        return drops[self.top]

    def _sweep(self, values: Mapping[str, float]) -> dict[str, Probability]:
        """Return the probability of every event and gate."""
        self._require_independent()
        nodes = {}
        for event in self.events:
            if event.parameter not in values:
                raise ModelError(
                    f"event '{event.name}': parameter '{event.parameter}' has no value; "
                    f"{one_of(values)}"
                )
            nodes[event.name] = Probability.of(values[event.parameter])
        for gate in self._upwards:
            inputs = [nodes[name] for name in gate.inputs]
            nodes[gate.name] = at_least(gate.threshold, inputs)
        return nodes

    def _require_independent(self) -> None:
        for name, gates in self.shared.items():
            raise ModelError(
                f"'{name}' is shared: it is an input {len(gates)} times, of "
                f"{', '.join(sorted(set(gates)))}; only trees in which every event and gate is "
                "an input once can be solved: give each its own event, or restructure the tree"
            )


def _names(tree: FaultTree) -> list[str]:
    return [gate.name for gate in tree.gates] + [event.name for event in tree.events]


def _find_shared(tree: FaultTree) -> dict[str, tuple[str, ...]]:
    above: dict[str, list[str]] = {}
    for gate in tree.gates:
        for name in gate.inputs:
            above.setdefault(name, []).append(gate.name)
    return {name: tuple(gates) for name, gates in above.items() if len(gates) > 1}


def _check_gate(gate: Gate, names: set[str]) -> None:
    for name in gate.inputs:
        if name not in names:
            raise ModelError(
                f"gate '{gate.name}': input '{name}' is no gate or event; {one_of(names, name)}"
            )
    if not gate.inputs and gate.kind is not GateKind.OR:
        raise ModelError(f"gate '{gate.name}': {gate.kind.value} needs at least one input")
    if gate.kind is not GateKind.ATLEAST:
        if gate.k is not None:
            raise ModelError(f"gate '{gate.name}': k is for atleast only; leave it out")
    elif gate.k is None or not 1 <= gate.k <= len(gate.inputs):
        raise ModelError(f"gate '{gate.name}': k is {gate.k}; allowed: 1 to {len(gate.inputs)}")


def _order_upwards(tree: FaultTree) -> tuple[Gate, ...]:
    """Return the gates, each after those below it; iterative, for trees of any depth."""
    gates = {gate.name: gate for gate in tree.gates}
    order: list[Gate] = []
    open_gates: set[str] = set()
    seen: set[str] = set()
    stack = [(tree.top, False)]
    while stack:
        name, below_done = stack.pop()
        gate = gates.get(name)
        if below_done and gate is not None:
            open_gates.discard(name)
            order.append(gate)
            continue
        if name in open_gates:
            raise ModelError(f"gate '{name}' stands above itself; break the cycle")
        if name in seen:
            continue
        seen.add(name)
        if gate is not None:
            open_gates.add(name)
            stack.append((name, True))
            stack.extend((child, False) for child in reversed(gate.inputs))
    loose = sorted(set(_names(tree)) - seen)
    if loose:
        raise ModelError(f"not below the top '{tree.top}': {', '.join(loose)}; join or remove them")
    return tuple(order)
