"""A fault tree as an integer graph: ANDs over signed literals, alike nodes made once.

A literal is a node's number, negative for its complement.
Node 1 is the constant that always happens; the events follow from 2 on, then the ANDs, each after
its arguments.
An OR is the complement of an AND of complements, so that the graph needs one kind of gate.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import neg

from tracerisk.prm.trees.gates import Gate, GateKind

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.trees.fault_tree import FaultTree

TRUE = 1
FALSE = -1
FIRST_EVENT = 2


@dataclass(frozen=True, slots=True)
class LogicGraph:
    """A Boolean function of events as a graph of ANDs.

    An AND's arguments are sorted by node, are at least two, and name each node once.
    """

    events: tuple[str, ...]
    """Names of the events; event number i is node i + 2, (n_events,)."""
    arguments: tuple[tuple[int, ...], ...]
    """Literals that each node is the AND of; empty where it is no AND, (n_nodes, n_arguments of
    the node)."""
    top: int
    """Literal of the top event; negative for the complement of its node."""

    @property
    def first_gate(self) -> int:
        """The number of the first node that is an AND."""
        return FIRST_EVENT + len(self.events)

    def event(self, literal: int) -> str:
        """Return the name of the event of a literal."""
        return self.events[abs(literal) - FIRST_EVENT]

    def with_constants(self, constants: Mapping[int, int]) -> LogicGraph:
        """Return the graph in which each node of `constants` is TRUE or FALSE, as they say."""
        builder = LogicBuilder(self.events)
        made = list(range(len(self.arguments)))
        for node in self.reachable():
            arguments = self.arguments[node]
            if node in constants:
                made[node] = constants[node]
            elif arguments:
                made[node] = builder.conjunction(renamed(argument, made) for argument in arguments)
        return builder.graph(renamed(self.top, made))

    def reachable(self) -> list[int]:
        """Return the nodes below and including the top, each after its arguments."""
        wanted = bytearray(len(self.arguments))
        wanted[abs(self.top)] = 1
        numbers = []
        for node in range(abs(self.top), 0, -1):
            if wanted[node]:
                numbers.append(node)
                for argument in self.arguments[node]:
                    wanted[abs(argument)] = 1
        numbers.reverse()
        return numbers


def renamed(literal: int, made: Sequence[int]) -> int:
    """Return the new literal, given what each node became."""
    return made[literal] if literal > 0 else -made[-literal]


class LogicBuilder:
    """Makes the nodes of a `LogicGraph`, simplified on the way: no node is ever made twice."""

    def __init__(self, events: Sequence[str]) -> None:
        self.events = tuple(events)
        self.arguments: list[tuple[int, ...]] = [()] * (FIRST_EVENT + len(self.events))
        self._known: dict[tuple[int, ...], int] = {}

    def conjunction(self, literals: Iterable[int]) -> int:
        """Return the literal that happens when all of `literals` do."""
        distinct = set(literals)
        distinct.discard(TRUE)
        if FALSE in distinct or not distinct.isdisjoint(map(neg, distinct)):
            return FALSE
        if len(distinct) < 2:
            return next(iter(distinct), TRUE)
        return self.ordered(tuple(sorted(distinct, key=abs)))

    def ordered(self, arguments: tuple[int, ...]) -> int:
        """Return the literal of an AND of arguments that stand as in a `LogicGraph`."""
        number = self._known.get(arguments)
        if number is None:
            number = self._known[arguments] = len(self.arguments)
            self.arguments.append(arguments)
        return number

    def disjunction(self, literals: Iterable[int]) -> int:
        """Return the literal that happens when any of `literals` does."""
        return -self.conjunction([-literal for literal in literals])

    def choice(self, condition: int, then: int, otherwise: int) -> int:
        """Return the literal that is `then` when the condition happens, else `otherwise`."""
        if then == otherwise:
            return then
        return self.disjunction(
            (self.conjunction((condition, then)), self.conjunction((-condition, otherwise)))
        )

    def at_least(self, k: int, literals: Sequence[int]) -> int:
        """Return the literal that happens when at least `k` of `literals` do.

        Partial counts are shared between combinations, which takes k (n - k + 1) two-way choices
        instead of one product for each combination.
        """
        count = len(literals)
        if k <= 0:
            return TRUE
        if k > count:
            return FALSE
        # Row of place i: at least r of the literals from i on; by r from 0 to k.
        row = [TRUE] + [FALSE] * k
        for place in range(count - 1, -1, -1):
            literal = literals[place]
            most = min(k, count - place)
            least = max(1, k - place)
            row = (
                row[:least]
                + [
                    self.disjunction((self.conjunction((literal, row[r - 1])), row[r]))
                    for r in range(least, most + 1)
                ]
                + row[most + 1 :]
            )
        return row[k]

    def between(self, least: int, most: int, literals: Sequence[int]) -> int:
        """Return the literal that happens when from `least` to `most` of `literals` do."""
        if least <= 0:
            return -self.at_least(most + 1, literals)
        if most >= len(literals):
            return self.at_least(least, literals)
        # Row of place i, by how many happened before it: whether the rest may end within bounds.
        row = [TRUE if least <= seen <= most else FALSE for seen in range(len(literals) + 1)]
        for place in range(len(literals) - 1, -1, -1):
            row = [
                self.choice(literals[place], row[seen + 1], row[seen]) for seen in range(place + 1)
            ]
        return row[0]

    def odd(self, literals: Sequence[int]) -> int:
        """Return the literal that happens when an odd number of `literals` does."""
        choice = FALSE
        for literal in literals:
            choice = self.choice(literal, -choice, choice)
        return choice

    def gate(self, gate: Gate, literals: Sequence[int]) -> int:
        """Return the literal of a fault tree's gate over its inputs' literals."""
        kind = gate.kind
        if kind is GateKind.OR:
            return self.disjunction(literals)
        if kind in (GateKind.AND, GateKind.INHIBIT, GateKind.TRANSFER):
            return self.conjunction(literals)
        if kind is GateKind.ATLEAST:
            return self.at_least(gate.threshold, literals)
        if kind is GateKind.CARDINALITY:
            return self.between(gate.k or 0, gate.most or 0, literals)
        if kind is GateKind.NOT or kind is GateKind.NAND:
            return -self.conjunction(literals)
        if kind is GateKind.NOR:
            return -self.disjunction(literals)
        if kind is GateKind.IMPLY:
            return self.disjunction((-literals[0], literals[1]))
        odd = self.odd(literals)
        return odd if kind is GateKind.XOR else -odd

    def graph(self, top: int) -> LogicGraph:
        """Return what was made, with `top` as its top."""
        return LogicGraph(self.events, tuple(self.arguments), top)


def logic_graph(tree: FaultTree) -> LogicGraph:
    """Return a fault tree as an integer graph; house events become constants."""
    builder = LogicBuilder([event.name for event in tree.events])
    literals = {event.name: number for number, event in enumerate(tree.events, FIRST_EVENT)}
    literals |= {house.name: TRUE if house.state else FALSE for house in tree.houses}
    for gate in tree.upwards:
        literals[gate.name] = builder.gate(gate, [literals[name] for name in gate.inputs])
    return builder.graph(literals[tree.top])
