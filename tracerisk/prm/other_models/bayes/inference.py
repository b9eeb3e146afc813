"""Exact inference in a network of conditions, by pyAgrum."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.bayes.tables import Given

if TYPE_CHECKING:
    from tracerisk.prm.other_models.bayes.network import BayesianNetwork
    from tracerisk.prm.other_models.bayes.tables import Distribution


def joint_probabilities(
    network: BayesianNetwork, conditions: tuple[str, ...], evidence: Mapping[str, str]
) -> dict[tuple[str, ...], float]:
    """Return the probability of each joint state of conditions that is not ruled out.

    Each is the sum, over the states of all other conditions, of products of table entries, over
    the same sum for the evidence.
    Raises ModelError when the evidence is impossible, or pyAgrum is not installed.
    """
    domains = [
        (evidence[name],) if name in evidence else network.states(name) for name in conditions
    ]
    # Conditions of one state are none; pyAgrum drops their dimension from some of its results.
    names = {
        name: f"n{index}"
        for index, name in enumerate(network.conditions)
        if len(network.states(name)) > 1
    }
    known = {
        names[name]: network.states(name).index(state)
        for name, state in evidence.items()
        if name in names
    }
    open_conditions = tuple(
        name for name, domain in zip(conditions, domains, strict=True) if len(domain) > 1
    )
    if not open_conditions and not known:
        return {tuple(domain[0] for domain in domains): 1.0}
    pyagrum = _pyagrum()
    inference = pyagrum.LazyPropagation(_translated(pyagrum, network, names))
    inference.setEvidence(known)
    wanted = {names[name] for name in open_conditions}
    if len(wanted) > 1:
        inference.addJointTarget(wanted)
    try:
        inference.makeInference()
        possible = not known or inference.evidenceProbability() > 0.0
    except pyagrum.IncompatibleEvidence:
        possible = False
    if not possible:
        text = ", ".join(f"{name} {state}" for name, state in evidence.items())
        raise ModelError(
            f"the evidence ({text}) has a probability of 0 or below 1e-308; correct it"
        )
    if not open_conditions:
        return {tuple(domain[0] for domain in domains): 1.0}
    if len(wanted) > 1:
        table = inference.jointPosterior(wanted)
    else:
        table = inference.posterior(next(iter(wanted)))
    probabilities = {}
    for joint in product(*domains):
        states = {
            names[name]: network.states(name).index(state)
            for name, state in zip(conditions, joint, strict=True)
            if name in open_conditions
        }
        probability = float(table[states])
        if probability > 0.0:
            probabilities[joint] = probability
    return probabilities


def _translated(pyagrum: Any, network: BayesianNetwork, names: Mapping[str, str]) -> Any:
    """Return the network as pyAgrum's; names and states there are numbers."""
    net = pyagrum.BayesNet()
    for name, number in names.items():
        net.add(pyagrum.LabelizedVariable(number, "", len(network.states(name))))
    for name, number in names.items():
        for parent in network.parents(name):
            if parent in names:
                net.addArc(names[parent], number)
    for name, number in names.items():
        condition, states = network.conditions[name], network.states(name)
        if not isinstance(condition, Given):
            net.cpt(number).fillWith(_normalised(condition, states))
            continue
        for given, row in condition.rows().items():
            place = {
                names[parent]: network.states(parent).index(state)
                for parent, state in zip(condition.names, given, strict=True)
                if parent in names
            }
            if place:
                net.cpt(number)[place] = _normalised(row, states)
            else:
                net.cpt(number).fillWith(_normalised(row, states))
    return net


def _normalised(row: Distribution, states: Sequence[str]) -> list[float]:
    """Return the probabilities of the states, divided by their sum, which is almost one."""
    total = math.fsum(row.values())
    return [row[state] / total for state in states]


def _pyagrum() -> Any:
    try:
        import pyagrum
    except ImportError as error:
        raise ModelError(
            "Bayesian networks need pyAgrum, which is not installed; "
            "install it with: pip install 'tracerisk[bayes]'"
        ) from error
    return pyagrum
