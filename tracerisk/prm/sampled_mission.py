"""The mission's failure probability of a hybrid model, for many draws of its parameters at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.prm.fault_tree import FaultTree
from tracerisk.prm.gates import gate_probability
from tracerisk.prm.hybrid import DONE, FunctionState, HybridModel
from tracerisk.prm.probability import Probability
from tracerisk.prm.sampled_chain import absorption_samples

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Samples = NDArray[np.float64]

_CELLS = 2_000_000
"""How many numbers one pass may hold; more draws are taken in passes."""


def failure_samples(model: HybridModel, thetas: Mapping[str, Samples]) -> Samples:
    """Return the mission's failure probability for each draw: (n,).

    `thetas` gives the drawn parameters their values, (n,) each; the others keep theirs.
    """
    count = len(next(iter(thetas.values())))
    events = sum(len(state.tree.events) + len(state.next) for state in model.states)
    step = max(64, _CELLS // max(events, 1))
    parts = [
        _failures(model, {name: values[start : start + step] for name, values in thetas.items()})
        for start in range(0, count, step)
    ]
    return np.concatenate(parts)


def _failures(model: HybridModel, thetas: Mapping[str, Samples]) -> Samples:
    before = {parameter.name: parameter.theta for parameter in model.parameters}
    count = len(next(iter(thetas.values())))
    reached = set(model.reachable)
    rows = {}
    failures = model.failure_states
    for state in model.states:
        if state.name in reached:
            top = _top(state, before, thetas)
            rows[state.name] = {failures[state.name]: top.p} | {
                step.target: top.q * float(step.weight) for step in state.next if step.weight > 0
            }
    absorbed = absorption_samples(rows, model.entry)
    total = np.zeros(count)
    for target, p in absorbed.items():
        if target != DONE:
            total += p
    return total


def _top(
    state: FunctionState, before: Mapping[str, float], thetas: Mapping[str, Samples]
) -> Probability:
    values: dict[str, float | Samples] = {}
    for name, value in state.probabilities.items():
        if name not in thetas:
            values[name] = value
        elif before[name] == 0.0:
            values[name] = thetas[name]
        else:
            values[name] = thetas[name] * (value / before[name])
    return tree_samples(state.tree, values)


def tree_samples(tree: FaultTree, values: Mapping[str, float | Samples]) -> Probability:
    """Return the top's pair (p, 1-p), each half an array over the draws or a number.

    `values` gives each parameter its probability.
    """
    if tree.shared:
        return _shared(tree, values)
    nodes = {event.name: _pair(values[event.parameter]) for event in tree.events}
    for house in tree.houses:
        nodes[house.name] = Probability.of(float(house.state))
    for gate in tree.upwards:
        nodes[gate.name] = gate_probability(gate, [nodes[name] for name in gate.inputs])
    return nodes[tree.top]


def _shared(tree: FaultTree, values: Mapping[str, float | Samples]) -> Probability:
    from tracerisk.prm.bdd import compiled

    count = max((len(v) for v in values.values() if isinstance(v, np.ndarray)), default=1)
    arrays = {
        event.name: np.broadcast_to(np.asarray(values[event.parameter], dtype=float), (count,))
        for event in tree.events
    }
    shared: Any = compiled(tree)
    found: Any = shared.probabilities(arrays)
    return Probability(found[:, 0], found[:, 1])


def _pair(value: float | Samples) -> Probability:
    # The pair's type is of numbers; its algebra is that of arrays as well.
    return Probability(value, 1.0 - value)  # type: ignore[arg-type]
