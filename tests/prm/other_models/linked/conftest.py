"""An independent solver of linked models: 250 digits, plain subtraction, brute force."""

from fractions import Fraction
from itertools import product

import pytest

from tracerisk.prm.other_models.expressions import (
    Call,
    Difference,
    MissionTime,
    Negation,
    Number,
    Product,
    Quotient,
    Reference,
    Sum,
)
from tracerisk.prm.other_models.expressions.laws import Exponential
from tracerisk.prm.other_models.linked import (
    Absorption,
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedModel,
    LinkedTree,
    ModelParameter,
    Occupancy,
    TopEvent,
    Transfer,
    Transition,
    complement,
)
from tracerisk.prm.trees.gates import Gate, GateKind

mpmath = pytest.importorskip("mpmath", reason="mpmath is the oracle of linked models")
mp = mpmath.mp.clone()
mp.dps = 250


class Oracle:
    """A model evaluated by definition; `values` stand in for parameters."""

    def __init__(self, model: LinkedModel, values=None) -> None:
        self.model = model
        self.values = {name: mp.mpf(value) for name, value in (values or {}).items()}
        self.known = {}
        self.trees = {tree.name: tree for tree in model.trees}
        self.chains = {chain.name: chain for chain in model.chains}

    def figure(self, figure):
        if isinstance(figure, str):
            figure = next(each.value for each in self.model.figures if each.name == figure)
        return self.of(figure)

    def slope(self, figure, name):
        """A derivative by a central difference, its error far below double precision."""
        at = self.values.get(name, self.of(self.model.parameter(name).value))
        step = at * mp.mpf(10) ** -25 if at else mp.mpf(10) ** -40
        ends = [
            Oracle(self.model, {**self.values, name: at + sign * step}).figure(figure)
            for sign in (1, -1)
        ]
        return (ends[0] - ends[1]) / (2 * step)

    def of(self, node):
        if node not in self.known:
            self.known[node] = self.evaluated(node)
        return self.known[node]

    def evaluated(self, node):
        if isinstance(node, Number):
            return mp.mpf(node.number)
        if isinstance(node, MissionTime):
            return mp.mpf(self.model.mission_time_h)
        if isinstance(node, Reference):
            if node.name in self.values:
                return self.values[node.name]
            return self.of(self.model.parameter(node.name).value)
        if isinstance(node, TopEvent):
            return self.top(self.trees[node.tree])
        if isinstance(node, Absorption):
            return self.absorption(self.chains[node.chain], node.states)
        if isinstance(node, Occupancy):
            return self.occupancy(node)
        terms = [self.of(each) for each in node.arguments]
        if isinstance(node, Sum):
            return sum(terms)
        if isinstance(node, Difference):
            return terms[0] - sum(terms[1:])
        if isinstance(node, Negation):
            return -terms[0]
        if isinstance(node, Product):
            return mp.fprod(terms)
        if isinstance(node, Quotient):
            return terms[0] / mp.fprod(terms[1:])
        if isinstance(node, Exponential):
            return 1 - mp.exp(-terms[0] * terms[1])
        if isinstance(node, Call):
            return {
                "exp": mp.exp,
                "log": mp.log,
                "sqrt": mp.sqrt,
                "pow": mp.power,
                "max": max,
                "min": min,
                "mean": lambda *x: sum(x) / len(x),
            }[node.function](*terms)
        raise NotImplementedError(node)

    def events(self, tree):
        found = {event.name: self.of(event.value) for event in tree.events}
        for transfer in tree.transfers:
            found |= self.events(self.trees[transfer.tree])
        return found

    def top(self, tree):
        events = self.events(tree)
        total = mp.mpf(0)
        for outcome in product((False, True), repeat=len(events)):
            happened = dict(zip(events, outcome, strict=True))
            if self.happens(tree, tree.top, happened):
                total += mp.fprod(p if happened[name] else 1 - p for name, p in events.items())
        return total

    def happens(self, tree, name, happened):
        for transfer in tree.transfers:
            if transfer.name == name:
                other = self.trees[transfer.tree]
                return self.happens(other, other.top, happened)
        for house in tree.houses:
            if house.name == name:
                return house.state
        gate = next((gate for gate in tree.gates if gate.name == name), None)
        if gate is None:
            return happened[name]
        count = sum(self.happens(tree, each, happened) for each in gate.inputs)
        if gate.kind is GateKind.XOR:
            return count % 2 == 1
        if gate.kind is GateKind.NOT:
            return count == 0
        needed = {"or": 1, "and": len(gate.inputs), "atleast": gate.k}[gate.kind.value]
        return count >= needed

    def matrix(self, chain):
        states = chain.states
        index = {state: place for place, state in enumerate(states)}
        found = mp.zeros(len(states))
        for step in chain.transitions:
            if step.value is not None:
                found[index[step.source], index[step.target]] += self.of(step.value)
        for state in states:
            taken = sum(found[index[state], place] for place in range(len(states)))
            rest = [step for step in chain.transitions if step.source == state and not step.value]
            for step in rest:
                share = mp.mpf(step.share.numerator) / step.share.denominator
                found[index[state], index[step.target]] += (1 - taken) * share
        return states, index, found

    def absorption(self, chain, targets):
        states, index, ways = self.matrix(chain)
        inner = [state for state in states if state not in chain.absorbing]
        for state in inner:
            total = sum(ways[index[state], place] for place in range(len(states)))
            for place in range(len(states)):
                ways[index[state], place] /= total
        left = mp.eye(len(inner))
        right = mp.zeros(len(inner), 1)
        for row, state in enumerate(inner):
            for column, other in enumerate(inner):
                left[row, column] -= ways[index[state], index[other]]
            right[row] = sum(ways[index[state], index[target]] for target in targets)
        if chain.entry in targets:
            return mp.mpf(1)
        if chain.entry in chain.absorbing:
            return mp.mpf(0)
        return mp.lu_solve(left, right)[inner.index(chain.entry)]

    def occupancy(self, link):
        chain = self.chains[link.chain]
        states, index, ways = self.matrix(chain)
        size = len(states)
        if chain.time == "continuous":
            for row in range(size):
                ways[row, row] = -sum(ways[row, column] for column in range(size))
            time = self.model.mission_time_h if link.time_h is None else link.time_h
            after = mp.expm(ways * mp.mpf(time), method="taylor")
        else:
            for state in chain.absorbing:
                ways[index[state], index[state]] = 1
            for row in range(size):
                total = sum(ways[row, column] for column in range(size))
                for column in range(size):
                    ways[row, column] /= total
            after = ways**link.steps
        return sum(after[index[chain.entry], index[state]] for state in link.states)


@pytest.fixture(scope="session")
def oracle():
    return Oracle


def number(value):
    return Number(float(value))


@pytest.fixture(scope="session")
def plant() -> LinkedModel:
    """Every kind of link: two trees that share events by a transfer, one tree in two states, a
    repairable part and a spare as chains behind events, sums, products and laws."""
    p = Reference
    pump = LinkedTree(
        "pump",
        "stops",
        (Gate("stops", GateKind.OR, ("power", "wear", "standby")),),
        (
            LinkedEvent("power", p("power")),
            LinkedEvent("wear", Exponential(p("wear rate"), MissionTime())),
            LinkedEvent("standby", Occupancy("standby", ("both",))),
        ),
    )
    cell = LinkedTree(
        "cell",
        "fails",
        (
            Gate("fails", GateKind.OR, ("arm", "supply")),
            Gate("arm", GateKind.ATLEAST, ("m1", "m2", "m3"), 2),
            Gate("supply", GateKind.AND, ("pump in", "other")),
            Gate("other", GateKind.OR, ("power", "m1")),
        ),
        (
            *(LinkedEvent(f"m{unit}", Sum((p("motor"), p("jam")))) for unit in (1, 2, 3)),
            LinkedEvent("power", p("power")),
        ),
        transfers=(Transfer("pump in", "pump"),),
    )
    odd = LinkedTree(
        "odd",
        "top",
        (Gate("top", GateKind.XOR, ("a", "b")),),
        (LinkedEvent("a", p("motor")), LinkedEvent("b", p("sensor"))),
    )
    standby = LinkedChain(
        "standby",
        "good",
        (
            Transition("good", "one", Product((number(2), p("wear rate")))),
            Transition("one", "both", p("wear rate")),
            Transition("one", "good", p("repair rate")),
            Transition("both", "one", p("repair rate")),
        ),
        "continuous",
    )
    mission = LinkedChain(
        "mission",
        "pick",
        (
            Transition("pick", "pick failed", TopEvent("cell")),
            Transition("pick", "dropped", Product((p("sensor"), complement(TopEvent("cell"))))),
            Transition("pick", "place", share=Fraction(9, 10)),
            Transition("pick", "pick", share=Fraction(1, 10)),
            Transition("place", "place failed", TopEvent("cell")),
            Transition("place", "pick", Product((number(0.75), complement(TopEvent("cell"))))),
            Transition("place", "done", Product((number(0.25), complement(TopEvent("cell"))))),
        ),
    )
    return LinkedModel(
        "plant",
        (
            ModelParameter("power", number(3e-9)),
            ModelParameter("motor", number(2e-6)),
            ModelParameter("jam", number(5e-7)),
            ModelParameter("sensor", Product((p("motor"), number(0.5)))),
            ModelParameter("wear rate", number(1e-6), "hour-1"),
            ModelParameter("repair rate", number(0.125), "hour-1"),
        ),
        (pump, cell, odd),
        (standby, mission),
        (
            Figure("failure", Absorption("mission", ("pick failed", "place failed"))),
            Figure("lost", Absorption("mission", ("dropped",))),
            Figure("done", Absorption("mission", ("done",))),
            Figure("after ten", Occupancy("mission", ("dropped", "pick failed"), steps=10)),
            Figure("unavailable", Occupancy("standby", ("both",))),
            Figure("odd", TopEvent("odd")),
            Figure("cost", Sum((Product((number(1e3), TopEvent("cell"))), TopEvent("odd")))),
        ),
        mission_time_h=24.0,
    )
