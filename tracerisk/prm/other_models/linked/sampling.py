"""A linked model evaluated for many draws of its parameters at once."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.numbers.absorption import absorption
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.numbers.strata import LatinHypercube
from tracerisk.prm.other_models.expressions import (
    Difference,
    Expression,
    Number,
    Product,
    Reference,
)
from tracerisk.prm.other_models.expressions.deviates import Deviate
from tracerisk.prm.other_models.linked.chain_solution import ChainToSolve
from tracerisk.prm.other_models.linked.derivative_tape import Tape
from tracerisk.prm.other_models.linked.links import Absorption, ElementKey, Link, Occupancy
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.other_models.linked.occupancy import SPARE, poisson_weights
from tracerisk.prm.other_models.linked.tree_solution import TreeToSolve
from tracerisk.prm.trees.sampled_tree import top_samples

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples, Values

_MOST_STEPS = 100_000

# The pair's type is of numbers; its algebra is that of arrays as well.
_Pair = Any


class SampledModel:
    """The elements of a model for n draws.

    `drawn` gives parameters their values, (n,) each; deviates that stand elsewhere are drawn by
    a Latin hypercube of their own from `seed`.
    """

    def __init__(self, model: LinkedModel, drawn: Mapping[str, Samples], *, seed: int = 0) -> None:
        self.model = model
        self._count = len(next(iter(drawn.values())))
        self._draws = LatinHypercube(self._count, seed)
        self._time_h = model.mission_time_h if model.mission_time_h is not None else math.nan
        self._parameters: dict[str, _Pair] = {}
        self._inputs: dict[ElementKey, list[_Pair]] = {}
        self._elements = {item.key: item.element for item in model.prepared}
        self._links: dict[Link, _Pair] = {}
        for prepared in model.prepared:
            key = prepared.key
            if prepared.element is None:
                name = key.name
                self._parameters[name] = (
                    Probability(drawn[name], 1.0 - drawn[name])  # type: ignore[arg-type]
                    if name in drawn
                    else self._value(prepared.tapes[0], f"{key}")
                )
            else:
                self._inputs[key] = [
                    self._value(tape, f"{key} {number}")
                    for number, tape in enumerate(prepared.tapes)
                ]

    def figure(self, name: str) -> Samples:
        """Return a figure for each draw: (n,)."""
        result = self._value(self.model.tape_of(name), f"figure '{name}'").p
        whole: Samples = np.array(np.broadcast_to(result, self._count))
        return whole

    def _value(self, tape: Tape, owner: str) -> _Pair:
        result: list[_Pair] = []
        for index, (node, places) in enumerate(zip(tape.nodes, tape.places, strict=True)):
            arguments = [result[place] for place in places]
            result.append(self._of(node, arguments, f"{owner}:{index}"))
        return result[-1]

    def _of(self, node: Expression, arguments: Sequence[_Pair], key: str) -> _Pair:
        if isinstance(node, Reference):
            return self._parameters[node.name]
        if isinstance(node, Link):
            if node not in self._links:
                self._links[node] = self._linked(node)
            return self._links[node]
        if isinstance(node, Number):
            return Probability(node.number, 1.0 - node.number)
        if isinstance(node, Product):
            p, q = 1.0, 0.0
            for pair in arguments:
                p, q = p * pair.p, q + p * pair.q
            return Probability(p, q)
        if isinstance(node, Difference) and len(arguments) == 2 and is_one(arguments[0].p):
            return Probability(arguments[1].q, arguments[1].p)
        numbers = [
            np.array(np.broadcast_to(np.asarray(pair.p, dtype=float), self._count))
            for pair in arguments
        ]
        if isinstance(node, Deviate):
            value = node.quantiles(numbers, self._draws.uniform(key))
        else:
            value = node.values(numbers, self._time_h, self._count)
        return Probability(value, 1.0 - value)  # type: ignore[arg-type]

    def _linked(self, link: Link) -> _Pair:
        element = self._elements[link.element]
        inputs = self._inputs[link.element]
        if isinstance(element, TreeToSolve):
            return self._top(element, inputs)
        assert isinstance(element, ChainToSolve)
        if isinstance(link, Absorption):
            return self._absorption(element, inputs, link)
        assert isinstance(link, Occupancy)
        return self._occupancy(element, inputs, link)

    def _top(self, made: TreeToSolve, inputs: Sequence[_Pair]) -> _Pair:
        values = {
            event.name: np.clip(pair.p, 0.0, 1.0)
            for event, pair in zip(made.tree.events, inputs, strict=True)
        }
        array = top_samples(made.tree, values, made.compiled if made.tree.shared else None)
        return Probability(array[:, 0], array[:, 1])  # type: ignore[arg-type]

    def _absorption(self, made: ChainToSolve, inputs: Sequence[_Pair], link: Absorption) -> _Pair:
        chain = made.chain
        rows: dict[Hashable, Mapping[Hashable, Values]] = {
            state: _row(made, state, inputs) for state in made.rows
        }
        absorbed = absorption(rows, chain.entry)
        p: Values = 0.0
        q: Values = 0.0
        for state in chain.absorbing:
            if state in link.states:
                p = p + absorbed.get(state, 0.0)
            else:
                q = q + absorbed.get(state, 0.0)
        # A sum of many shares of one may exceed it by rounding.
        return Probability(np.minimum(p, 1.0), np.minimum(q, 1.0))  # type: ignore[arg-type]

    def _occupancy(self, made: ChainToSolve, inputs: Sequence[_Pair], link: Occupancy) -> _Pair:
        chain = made.chain
        rows: dict[str, dict[Hashable, Values]]
        if chain.time == "discrete":
            rows = {state: _row(made, state, inputs) for state in made.rows}
            weights: Sequence[Values] = [0.0] * (link.steps or 0) + [1.0]
        else:
            rates = {
                state: {target: inputs[place].p for target, place in row.explicit.items()}
                for state, row in made.rows.items()
            }
            leaving = {state: sum(row.values()) for state, row in rates.items()}
            fastest = np.maximum.reduce(
                [np.broadcast_to(rate, self._count) for rate in leaving.values()]
            )
            pace = np.where(fastest > 0.0, SPARE * fastest, 1.0)
            rows = {
                state: {state: (pace - leaving[state]) / pace}
                | {target: rate / pace for target, rate in row.items()}
                for state, row in rates.items()
            }
            time_h = self._time_h if link.time_h is None else link.time_h
            weights = _poisson(pace * time_h, len(chain.states))
        now: dict[Hashable, Values] = dict.fromkeys(chain.states, 0.0)
        now[chain.entry] = 1.0
        p: Values = 0.0
        q: Values = 0.0
        for step, weight in enumerate(weights):
            if step:
                now = _stepped(now, rows)
            for state, share in now.items():
                if state in link.states:
                    p = p + weight * share
                else:
                    q = q + weight * share
        return Probability(p, q)  # type: ignore[arg-type]


def is_one(value: Any) -> bool:
    """Return whether a value is the number one, not drawn."""
    return isinstance(value, float | int) and value == 1.0


def _row(made: ChainToSolve, state: str, inputs: Sequence[_Pair]) -> dict[Hashable, Values]:
    row = made.rows[state]
    shares: dict[Hashable, Values] = {
        target: inputs[place].p for target, place in row.explicit.items()
    }
    if row.remainder:
        taken = [inputs[place] for place in row.explicit.values()]
        left: Values = 1.0
        if len(taken) == 1:
            left = taken[0].q
        elif taken:
            left = np.maximum(0.0, 1.0 - sum(pair.p for pair in taken))
        for target, share in row.remainder.items():
            way = left * share
            shares[target] = shares[target] + way if target in shares else way
    for there, p in shares.items():
        if np.any(np.asarray(p) < 0.0) or np.any(np.asarray(p) > 1.0 + 1e-12):
            raise ModelError(
                f"{made.chain.key}, state '{state}': a draw gives '{there}' a probability outside "
                "[0, 1]; narrow the distributions"
            )
    return shares


def _stepped(
    now: Mapping[Hashable, Values], rows: Mapping[str, Mapping[Hashable, Values]]
) -> dict[Hashable, Values]:
    following: dict[Hashable, Values] = {
        place: 0.0 if place in rows else share for place, share in now.items()
    }
    for source, ways in rows.items():
        for target, share in ways.items():
            following[target] = following[target] + now[source] * share
    return following


def _poisson(means: Samples, least: int) -> list[Values]:
    """Return the Poisson probabilities of 0, 1, 2... events for each mean: (n,) each."""
    greatest = float(means.max())
    if greatest > _MOST_STEPS:
        raise TooLargeError(
            f"a chain in continuous time takes {greatest:.3g} steps in a draw; allowed: "
            f"{_MOST_STEPS}; give a shorter time, or slower rates"
        )
    logs = np.log(means)
    return [
        np.exp(count * logs - means - math.lgamma(count + 1.0))
        for count in range(len(poisson_weights(greatest, least)))
    ]
