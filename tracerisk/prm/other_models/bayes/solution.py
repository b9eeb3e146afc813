"""A fault tree over a network of conditions, solved state by state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability, mean_of
from tracerisk.prm.numbers.quantities import check_parameters
from tracerisk.prm.trees.fault_tree import FaultTree

if TYPE_CHECKING:
    from tracerisk.prm.other_models.bayes.network import BayesianNetwork
    from tracerisk.prm.other_models.bayes.tables import States


@dataclass(frozen=True, slots=True)
class SolvedCase:
    """A joint state of the conditions, with the top event in it."""

    states: States
    """State of each condition that bears on the tree."""
    probability: float
    """Probability of the joint state, given the evidence."""
    top: Probability
    """Probability of the top event in this state."""


@dataclass(frozen=True, slots=True)
class BayesianSolution:
    """The top event over all states of the conditions that bear on it.

    Sums over the cases are of products of non-negative numbers: both halves of the pair keep
    their relative precision.
    """

    network: BayesianNetwork
    """The network that was solved."""
    evidence: States
    """Known states of conditions."""
    cases: tuple[SolvedCase, ...]
    """The joint states, which exclude each other and cover everything."""

    @property
    def top(self) -> Probability:
        """The top event's probability and its complement, given the evidence."""
        return mean_of((case.probability, case.top) for case in self.cases)

    def posterior(self, condition: str, *, top_happened: bool = True) -> dict[str, float]:
        """Return the probability of each state of a condition, given that the top happened.

        Bayes' rule over the cases: P(state | top) = sum_c P(state, c) P(top | c) / P(top).
        `top_happened=False` gives it for the top that did not happen.
        Raises ModelError when there is no such condition, or what is given is impossible.
        """
        total = self.top.p if top_happened else self.top.q
        if not total > 0.0:
            said = "never happens" if top_happened else "always happens"
            raise ModelError(
                f"the top event {said}; probabilities given its complement are undefined"
            )
        bearing = tuple(self.cases[0].states)
        given = {tuple(case.states.values()): case.top for case in self.cases}
        parts: dict[str, list[float]] = {}
        for joint, probability in self.network.joint((*bearing, condition), self.evidence).items():
            top = given[joint[: len(bearing)]]
            state = joint[(*bearing, condition).index(condition)]
            parts.setdefault(state, []).append(probability * (top.p if top_happened else top.q))
        return {
            state: math.fsum(parts.get(state, ())) / total
            for state in self.network.states(condition)
        }


def solve_network(
    network: BayesianNetwork,
    tree: FaultTree,
    values: Mapping[str, float],
    mission_time_h: float | None,
    evidence: States,
) -> BayesianSolution:
    """Solve a fault tree for each joint state of the conditions; see BayesianNetwork.solve."""
    check_parameters(values, dict.fromkeys(tree.parameters))
    for name in values:
        if name in network.events:
            raise ModelError(
                f"a value is given for '{name}', which the network defines already; remove one "
                "of the two"
            )
    cases = network.cases(tree.parameters, mission_time_h=mission_time_h, evidence=evidence)
    # States that give the events the same figures have the same top.
    figures = dict.fromkeys(tuple(case.values.values()) for case in cases)
    bearing = tuple(cases[0].values)
    given: dict[str, float | list[float]] = {**tree.values_at(mission_time_h), **values}
    given.update(zip(bearing, map(list, zip(*figures, strict=True)), strict=True))
    tolist = tree.probabilities(given).tolist()
    tops = {row: Probability(p, q) for row, (p, q) in zip(figures, tolist, strict=True)}
    solved = [
        SolvedCase(case.states, case.probability, tops[tuple(case.values.values())])
        for case in cases
    ]
    return BayesianSolution(network, dict(evidence), tuple(solved))
