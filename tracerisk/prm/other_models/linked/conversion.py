"""A hybrid model of functions as a linked model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

from tracerisk.errors import TooLargeError
from tracerisk.prm.hybrid.elements import DONE, FunctionState
from tracerisk.prm.hybrid.hidden.hidden_states import hidden_states, survives
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.other_models.expressions import (
    Call,
    Expression,
    Negation,
    Number,
    Product,
    Reference,
    Sum,
)
from tracerisk.prm.other_models.linked.elements import (
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedTree,
    ModelParameter,
    Transition,
)
from tracerisk.prm.other_models.linked.links import Absorption, Occupancy, TopEvent, complement
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind

if TYPE_CHECKING:
    from tracerisk.prm.hybrid.hidden.hidden_states import Function, Hidden, HiddenStates

MISSION = "mission"
FAILURE = "mission failure"

_GROUP_FAILED = "group failed"

MOST_STATES = 2_000
"""How many states the chain of a converted model may have, with hidden failures."""


def linked(model: HybridModel) -> LinkedModel:
    """Return the model as parameters, a fault tree for each function, and the mission's chain.

    Its figures are the mission's failure probability, by the chain, and each function's part
    of it, named after its failure state.
    With latent units each function stands in the chain once for each number of them that can
    have failed unnoticed, with a fault tree in which these have failed.
    The visits of a group with spares are chains in continuous time of one hour, in which the rate
    of a working unit is -log(1-p), one for each number of its units failed before.
    Raises TooLargeError when that makes more than `MOST_STATES` states.
    """
    thetas = {parameter.name: parameter.theta for parameter in model.parameters}
    reached = set(model.reachable)
    failures = model.failure_states
    absorbing = tuple(failures[state.name] for state in model.states if state.name in reached)
    visits: tuple[LinkedChain, ...] = ()
    if model.latent:
        unfolded = _Unfolded(model, thetas)
        trees, transitions = unfolded.parts()
        visits = tuple(unfolded.visits.values())
    else:
        trees = [_tree(state, thetas) for state in model.states]
        transitions = [
            step
            for state in model.states
            if state.name in reached
            for step in _transitions(state, failures[state.name])
        ]
    return LinkedModel(
        name=model.name,
        parameters=tuple(
            ModelParameter(item.name, Number(item.theta), distribution=item.distribution)
            for item in model.parameters
        ),
        trees=tuple(trees),
        chains=(*visits, LinkedChain(MISSION, model.entry, tuple(transitions))),
        figures=(
            Figure(FAILURE, Absorption(MISSION, absorbing)),
            Figure(DONE, Absorption(MISSION, (DONE,))),
            *(Figure(name, Absorption(MISSION, (name,))) for name in absorbing),
        ),
    )


def _tree(state: FunctionState, thetas: Mapping[str, float]) -> LinkedTree:
    values = ((name, _figure(state, name, thetas)) for name in state.tree.parameters)
    return LinkedTree.of(state.name, state.tree, values)


def _figure(state: FunctionState, name: str, thetas: Mapping[str, float]) -> Expression:
    """Return a state's figure of a parameter: theta, or theta times a factor."""
    value = state.probabilities[name]
    if thetas[name] == 0.0 or value == thetas[name]:
        return Reference(name)
    return Product((Reference(name), Number(value / thetas[name])))


def _transitions(state: FunctionState, failure: str) -> Iterator[Transition]:
    yield Transition(state.name, failure, TopEvent(state.name))
    for step in state.next:
        if step.weight > 0:
            yield Transition(state.name, step.target, share=step.weight)


class _Unfolded:
    """The chain of functions times hidden failures, each state with its own fault tree."""

    def __init__(self, model: HybridModel, thetas: Mapping[str, float]) -> None:
        self._model = model
        self._thetas = thetas
        self._states: HiddenStates = hidden_states(model, MOST_STATES)
        if self._states.most is not None:
            raise TooLargeError(
                f"'{model.name}' has more than {MOST_STATES} states with its hidden failures; "
                "solve it as it is, or state `detected each_visit` for some components"
            )
        self._labels = _labels(self._states.classes)
        self.visits: dict[tuple[int, int, int], LinkedChain] = {}
        self._number = {
            function.state.name: number for number, function in enumerate(self._states.functions)
        }

    def parts(self) -> tuple[list[LinkedTree], list[Transition]]:
        """Return the fault trees and the transitions, from the entry on."""
        trees: list[LinkedTree] = []
        transitions: list[Transition] = []
        start = (self._states.entry, (0,) * len(self._states.classes))
        seen: dict[tuple[int, Hidden], None] = {start: None}
        waiting = [start]
        while waiting:
            number, hidden = waiting.pop()
            function = self._states.functions[number]
            name = self._name(number, hidden)
            failure = self._model.failure_states[function.state.name]
            trees.append(self._tree(function, hidden, name))
            transitions.append(Transition(name, failure, TopEvent(name)))
            for after, ways in self._outcomes(function, hidden):
                for step in function.state.next:
                    if step.weight == 0:
                        continue
                    value = _times([*ways, *_weight(step.weight)])
                    if step.target == DONE:
                        transitions.append(Transition(name, DONE, value))
                        continue
                    following = (self._number[step.target], after)
                    transitions.append(Transition(name, self._name(*following), value))
                    if following not in seen:
                        seen[following] = None
                        waiting.append(following)
        for function in self._states.functions:
            if function.rest.events and function.parts:
                rest = replace(function.state, name=self._rest(function), tree=function.rest)
                trees.append(_tree(rest, self._thetas))
        return trees, _merged(transitions)

    def _outcomes(
        self, function: Function, hidden: Hidden
    ) -> Iterator[tuple[Hidden, list[Expression]]]:
        """Yield the hidden states that a visit can leave, each with the factors of its way."""
        if not survives(function.parts, hidden):
            return
        classes = self._states.classes
        number = self._number[function.state.name]
        used = sorted(function.parameters)
        sound: list[Expression] = []
        if function.parts:
            if function.rest.events:
                sound = [complement(TopEvent(self._rest(function)))]
        else:
            sound = [complement(TopEvent(self._name(self._number[function.state.name], hidden)))]
        for more in product(*(range(len(classes[c]) - hidden[c] + 1) for c in used)):
            grown = dict(zip(used, more, strict=True))
            after = tuple(count + grown.get(c, 0) for c, count in enumerate(hidden))
            if survives(function.parts, after) and self._can_be(number, hidden, grown):
                ways = list(sound)
                for c, failed in grown.items():
                    if c in function.spares:
                        chain = self._visit(number, c, hidden[c])
                        ways.append(Occupancy(chain.name, (_more(failed),), time_h=1.0))
                        continue
                    p = _figure(function.state, function.parameters[c], self._thetas)
                    ways += _binomial(len(classes[c]) - hidden[c], failed, p)
                yield after, ways

    def _tree(self, function: Function, hidden: Hidden, name: str) -> LinkedTree:
        """Return a function's fault tree with the hidden failures as events that have happened."""
        gone = {
            unit
            for count, units in zip(hidden, self._states.classes, strict=True)
            for unit in units[:count]
        }
        whole = _tree(function.state, self._thetas)
        groups: dict[str, Expression | None] = {}
        gates = []
        for gate in whole.gates:
            if gate.name in function.state.spares:
                units, group = gate.inputs, f"{gate.name}[spares]"
                groups[group] = self._group_failure(function, hidden, units[0])
                gone |= set(units)
                gate = Gate(gate.name, GateKind.OR, (group,))
            gates.append(gate)
        used = {name for gate in gates for name in gate.inputs}
        return replace(
            whole,
            name=name,
            gates=tuple(gates),
            events=(
                *(event for event in whole.events if event.name not in gone),
                *(LinkedEvent(group, value) for group, value in groups.items() if value),
            ),
            houses=(
                *whole.houses,
                *(
                    HouseEvent(event.name, True)
                    for event in whole.events
                    if event.name in gone and event.name in used
                ),
                *(HouseEvent(group, True) for group, value in groups.items() if not value),
            ),
        )

    def _group_failure(self, function: Function, hidden: Hidden, unit: str) -> Expression | None:
        """Return how probably a group with spares fails a visit; `None` if it surely does."""
        unit_class = next(c for c, units in enumerate(self._states.classes) if unit in units)
        group = function.spares[unit_class]
        if hidden[unit_class] > group.units - group.required:
            return None
        chain = self._visit(self._number[function.state.name], unit_class, hidden[unit_class])
        return Occupancy(chain.name, (_GROUP_FAILED,), time_h=1.0)

    def _can_be(self, number: int, hidden: Hidden, grown: Mapping[int, int]) -> bool:
        """Return whether so many spares can fail in a visit: with a sure switch none takes over."""
        spares = self._states.functions[number].spares
        return all(
            _more(failed) in self._visit(number, c, hidden[c]).states
            for c, failed in grown.items()
            if c in spares
        )

    def _visit(self, number: int, unit_class: int, lost: int) -> LinkedChain:
        """Return the chain of one visit of a group with spares, so many units failed before."""
        key = (number, unit_class, lost)
        if key not in self.visits:
            function = self._states.functions[number]
            group = function.spares[unit_class]
            p = _figure(function.state, function.parameters[unit_class], self._thetas)
            hazard = Negation(Call("log", (complement(p),)))
            steps = []
            for more in range(group.units - group.required - lost + 1):
                ways = zip((_more(more + 1), _GROUP_FAILED), group.rates(lost + more), strict=True)
                rates = [(target, rate) for target, rate in ways if rate > 0.0]
                steps += [
                    Transition(_more(more), target, Product((Number(rate), hazard)))
                    for target, rate in rates
                ]
                if _more(more + 1) not in dict(rates):
                    break
            name = f"{function.state.name} [{self._labels[unit_class]}, {lost} failed before]"
            self.visits[key] = LinkedChain(name, _more(0), tuple(steps), "continuous")
        return self.visits[key]

    def _name(self, number: int, hidden: Hidden) -> str:
        name = self._states.functions[number].state.name
        failed = [
            f"{count} {label}" for count, label in zip(hidden, self._labels, strict=True) if count
        ]
        return f"{name} [{', '.join(failed)} failed]" if failed else name

    @staticmethod
    def _rest(function: Function) -> str:
        return f"{function.state.name} [rest]"


def _more(failed: int) -> str:
    return f"{failed} more failed"


def _labels(classes: Sequence[Sequence[str]]) -> list[str]:
    """Return a name for each class of units: what stands before their numbers, if that differs."""
    short = [units[0].partition("[")[0] for units in classes]
    return [
        label if short.count(label) == 1 else " ".join(units)
        for label, units in zip(short, classes, strict=True)
    ]


def _weight(weight: Fraction) -> list[Expression]:
    return [] if weight == 1 else [Number(float(weight))]


def _times(factors: Sequence[Expression]) -> Expression:
    if not factors:
        return Number(1.0)
    return factors[0] if len(factors) == 1 else Product(tuple(factors))


def _binomial(units: int, failed: int, p: Expression) -> list[Expression]:
    """Return the factors of the probability that so many of so many units fail."""
    choices = math.comb(units, failed)
    lead: list[Expression] = [] if choices == 1 else [Number(float(choices))]
    return [*lead, *[p] * failed, *[complement(p)] * (units - failed)]


def _merged(transitions: Sequence[Transition]) -> list[Transition]:
    """Return the transitions, those between the same two states added up."""
    expressions: dict[tuple[str, str], list[Expression]] = {}
    for step in transitions:
        if step.value is not None:
            expressions.setdefault((step.source, step.target), []).append(step.value)
    return [
        Transition(source, target, values[0] if len(values) == 1 else Sum(tuple(values)))
        for (source, target), values in expressions.items()
    ]
