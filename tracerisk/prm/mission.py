"""The chain of a hybrid model, and the mission's figures on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.prm.assessment import MissionFigures
from tracerisk.prm.hybrid import DONE, HybridModel
from tracerisk.prm.markov import ChainSolution, MarkovChain
from tracerisk.prm.probability import Probability

Tops = Mapping[str, Probability]
"""The top event's probability of each state that the entry leads to."""


@dataclass(frozen=True, slots=True)
class SolvedMission:
    """A model's chain, solved for one assignment of the top events.

    `done_from` gives for each state, and for `done` itself, the probability that a mission
    which stands there succeeds.
    """

    failure: Probability
    visits: Mapping[str, float]
    absorption: Mapping[str, float]
    done_from: Mapping[str, float]


def hybrid_chain(model: HybridModel, tops: Tops) -> MarkovChain:
    """Return the model's chain: each state fails with its top, else goes on by `next`.

    States that the entry never leads to are left out.
    """
    failure_states = model.failure_states
    rows = {}
    for state in model.states:
        if state.name in tops:
            top = tops[state.name]
            rows[state.name] = {failure_states[state.name]: top.p} | {
                step.target: top.q * float(step.weight) for step in state.next if step.weight > 0
            }
    return MarkovChain(rows, (*(failure_states[name] for name in rows), DONE))


def solve_mission(model: HybridModel, tops: Tops) -> SolvedMission:
    """Solve the model's chain from its entry."""
    solution = hybrid_chain(model, tops).solve(model.entry)
    failure_states = model.failure_states
    absorption = solution.absorption()
    failures = {name: absorption[failure_states[name]] for name in tops}
    return SolvedMission(
        failure=Probability(math.fsum(failures.values()), absorption[DONE]),
        visits=solution.expected_visits(),
        absorption=failures,
        done_from={**solution.absorption_from_each((DONE,)), DONE: 1.0},
    )


def mission_figures(model: HybridModel, tops: Tops, solved: SolvedMission) -> MissionFigures:
    """Return the mission's failure probability read in three ways."""
    sound = {name: Probability(0.0, 1.0) for name in tops}
    visits = hybrid_chain(model, sound).solve(model.entry).expected_visits()
    cycle = _one_cycle(model, tops)
    cycles = visits[model.entry]
    return MissionFigures(
        failure_probability=solved.failure.p,
        done_probability=solved.failure.q,
        cycle_failure_probability=cycle.p,
        expected_cycles=cycles,
        fixed_cycles=-math.expm1(cycles * _log_survival(cycle)),
        visits_as_run=-math.expm1(
            math.fsum(count * _log_survival(tops[name]) for name, count in visits.items())
        ),
    )


def _one_cycle(model: HybridModel, tops: Tops) -> Probability:
    """Return the failure probability of the chain cut where it comes back to the entry."""
    whole = hybrid_chain(model, tops)
    # A line break keeps the cut apart from any state's name.
    cut = f"back\nat {model.entry}"
    rows = {
        state: {cut if target == model.entry else target: p for target, p in row.items()}
        for state, row in whole.transitions.items()
    }
    solution: ChainSolution = MarkovChain(rows, (*whole.absorbing, cut)).solve(model.entry)
    absorption = solution.absorption()
    good = (DONE, cut)
    return Probability(
        math.fsum(p for state, p in absorption.items() if state not in good),
        math.fsum(absorption[state] for state in good),
    )


def _log_survival(probability: Probability) -> float:
    """Return log(1-p) from the more precise half of the pair."""
    if probability.q == 0.0:
        return -math.inf
    if probability.p < 0.5:
        return math.log1p(-probability.p)
    return math.log(probability.q)
