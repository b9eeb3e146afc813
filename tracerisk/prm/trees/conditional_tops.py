"""A top event given that an event happens, and given that it does not: of all events at once.

The top's pair is linear in the pair of each node below it, with the two conditional pairs as its
factors; they go from a gate to its inputs by the gate's own conditional pairs.
All are sums of products of probabilities, so that the top without an event keeps its precision
where its difference to the top would not (own derivation).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.prm.numbers.probability import MANY, Probability, log_products
from tracerisk.prm.trees.gates import Gate, GateKind, gate_probability

if TYPE_CHECKING:
    from tracerisk.prm.trees.bdd import SharedTree
    from tracerisk.prm.trees.fault_tree import FaultTree

SURE, NEVER = Probability(1.0, 0.0), Probability(0.0, 1.0)


class Conditional(NamedTuple):
    """The probability of a gate or top, conditional on a node below it."""

    given: Probability
    """Probability given that the node happens."""
    without: Probability
    """Probability given that the node does not happen."""

    @property
    def complement(self) -> Conditional:
        """The same of the complementary gate or top."""
        return Conditional(self.given.complement, self.without.complement)


def conditional_tops(tree: FaultTree, nodes: Mapping[str, Probability]) -> dict[str, Conditional]:
    """Return the top's pairs given each event, of a tree that shares no gate or event.

    `nodes` are the pairs of all gates, events and house events.
    """
    row = {tree.top: Conditional(SURE, NEVER)}
    for gate in reversed(tree.upwards):
        above = row[gate.name]
        inputs = [nodes[name] for name in gate.inputs]
        for name, own in zip(gate.inputs, gate_conditionals(gate, inputs), strict=True):
            row[name] = Conditional(_mixed(own.given, above), _mixed(own.without, above))
    return {event.name: row[event.name] for event in tree.events}


def shared_conditional_tops(
    shared: SharedTree, events: Mapping[str, Probability]
) -> dict[str, Conditional]:
    """Return the top's pairs given each event, of a tree that shares gates or events.

    The top changes by its derivative times the event's change; where that would take away more
    than half of a figure, the tree is solved anew.
    """
    top, slopes = shared.probability(events), shared.sensitivities(events)
    conditional_tops = {}
    for name, pair in events.items():
        rise, fall = slopes[name] * pair.q, slopes[name] * pair.p
        given = Probability(top.p + rise, top.q - rise)
        without = Probability(top.p - fall, top.q + fall)
        if not _kept(given, top):
            given = shared.probability({**events, name: SURE})
        if not _kept(without, top):
            without = shared.probability({**events, name: NEVER})
        conditional_tops[name] = Conditional(given, without)
    return conditional_tops


def _kept(found: Probability, top: Probability) -> bool:
    return found.p >= top.p / 2 and found.q >= top.q / 2


def gate_conditionals(gate: Gate, inputs: Sequence[Probability]) -> list[Conditional]:
    """Return a gate's pairs given each of its independent inputs."""
    kind, count = gate.kind, len(inputs)
    if kind in (GateKind.XOR, GateKind.IFF):
        odd = [Conditional(other.complement, other) for other in _others(inputs, _either, NEVER)]
        return odd if kind is GateKind.XOR else [probability.complement for probability in odd]
    if kind in (GateKind.IMPLY, GateKind.CARDINALITY) or 1 < gate.threshold < count:
        return [
            Conditional(
                gate_probability(gate, [*inputs[:place], SURE, *inputs[place + 1 :]]),
                gate_probability(gate, [*inputs[:place], NEVER, *inputs[place + 1 :]]),
            )
            for place in range(count)
        ]
    if gate.threshold == 1:
        joined = [Conditional(SURE, other) for other in _any_others(inputs)]
    else:
        dual = _any_others([pair.complement for pair in inputs])
        joined = [Conditional(other.complement, NEVER) for other in dual]
    if kind in (GateKind.NOT, GateKind.NAND, GateKind.NOR):
        return [probability.complement for probability in joined]
    return joined


def _mixed(gate: Probability, top: Conditional) -> Probability:
    """Return the top's pair where a gate below it has a pair."""
    return Probability(
        gate.p * top.given.p + gate.q * top.without.p, gate.p * top.given.q + gate.q * top.without.q
    )


def _others(
    inputs: Sequence[Probability],
    join: Callable[[Probability, Probability], Probability],
    none: Probability,
) -> list[Probability]:
    """Return for each input all others joined."""
    heads = accumulate(inputs[:-1], join, initial=none)
    tails = list(accumulate(inputs[:0:-1], join, initial=none))
    return [join(head, tail) for head, tail in zip(heads, reversed(tails), strict=True)]


def _any_others(inputs: Sequence[Probability]) -> list[Probability]:
    """Return for each input whether any other happens; of many by logarithms, see `any_of`."""
    if len(inputs) < MANY:
        return _others(inputs, _any, NEVER)
    heads, tails = log_products(inputs[:-1]), log_products(inputs[:0:-1])
    return [
        Probability(-math.expm1(head + tail), math.exp(head + tail))
        for head, tail in zip(heads, reversed(tails), strict=True)
    ]


def _any(a: Probability, b: Probability) -> Probability:
    return Probability(a.p + a.q * b.p, a.q * b.q)


def _either(a: Probability, b: Probability) -> Probability:
    return Probability(a.p * b.q + a.q * b.p, a.p * b.p + a.q * b.q)
