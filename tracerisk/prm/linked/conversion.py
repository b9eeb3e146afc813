"""A hybrid model of functions as a linked model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.expressions import Expression, Number, Product, Reference, Sum
from tracerisk.prm.hybrid.hybrid import DONE, FunctionState, HybridModel
from tracerisk.prm.linked.elements import (
    Figure,
    LinkedChain,
    LinkedTree,
    ModelParameter,
    Transition,
)
from tracerisk.prm.linked.links import Absorption, TopEvent, complement
from tracerisk.prm.linked.model import LinkedModel
from tracerisk.prm.trees.fault_tree import HouseEvent

if TYPE_CHECKING:
    from tracerisk.prm.hybrid.hidden_states import Function, Hidden, HiddenStates

MISSION = "mission"
FAILURE = "mission failure"

MOST_STATES = 2_000
"""How many states the chain of a converted model may have, with hidden failures."""


def linked(model: HybridModel) -> LinkedModel:
    """Return the model as parameters, a fault tree for each function, and the mission's chain.

    Its figures are the mission's failure probability, by the chain, and each function's part
    of it, named after its failure state.
    With latent units each function stands in the chain once for each number of them that can
    have failed unnoticed, with a fault tree in which these have failed.
    Raises TooLargeError when that makes more than `MOST_STATES` states, ModelError for groups with
    spares whose failures stay hidden, of which no expression tells how many fail in a visit.
    """
    waiting = [f"'{gate}' of {state.name}" for state in model.states for gate in state.spares]
    if waiting:
        raise ModelError(
            f"{waiting[0]} has spares, and no expression of a linked model tells how many of them "
            "fail in a visit; solve the model of functions itself, or convert its chain"
        )
    thetas = {parameter.name: parameter.theta for parameter in model.parameters}
    reached = set(model.reachable)
    failures = model.failure_states
    absorbing = tuple(failures[state.name] for state in model.states if state.name in reached)
    if model.latent:
        trees, transitions = _Unfolded(model, thetas).parts()
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
            ModelParameter(each.name, Number(each.theta), distribution=each.distribution)
            for each in model.parameters
        ),
        trees=tuple(trees),
        chains=(LinkedChain(MISSION, model.entry, tuple(transitions)),),
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
        from tracerisk.prm.hybrid.hidden_states import hidden_states

        self._model = model
        self._thetas = thetas
        self._states: HiddenStates = hidden_states(model, MOST_STATES)
        if self._states.most is not None:
            raise TooLargeError(
                f"'{model.name}' has more than {MOST_STATES} states with its hidden failures; "
                "solve it as it is, or state `detected each_visit` for some components"
            )
        self._labels = _labels(self._states.classes)
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
        if not _survives(function, hidden):
            return
        classes = self._states.classes
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
            if _survives(function, after):
                ways = list(sound)
                for c, failed in grown.items():
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
        return replace(
            whole,
            name=name,
            events=tuple(event for event in whole.events if event.name not in gone),
            houses=(
                *whole.houses,
                *(HouseEvent(event.name, True) for event in whole.events if event.name in gone),
            ),
        )

    def _name(self, number: int, hidden: Hidden) -> str:
        name = self._states.functions[number].state.name
        failed = [
            f"{count} {label}" for count, label in zip(hidden, self._labels, strict=True) if count
        ]
        return f"{name} [{', '.join(failed)} failed]" if failed else name

    @staticmethod
    def _rest(function: Function) -> str:
        return f"{function.state.name} [rest]"


def _survives(function: Function, hidden: Hidden) -> bool:
    """Return whether a visit with so many failed units goes on, if nothing else fails."""
    return all(sum(hidden[c] for c in part.classes) < part.threshold for part in function.parts)


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
    found: dict[tuple[str, str], list[Expression]] = {}
    for step in transitions:
        if step.value is not None:
            found.setdefault((step.source, step.target), []).append(step.value)
    return [
        Transition(source, target, values[0] if len(values) == 1 else Sum(tuple(values)))
        for (source, target), values in found.items()
    ]
