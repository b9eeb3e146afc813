"""Event trees and Bayesian networks beside a linked model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.probability import Probability, mean_of
from tracerisk.prm.other_models.bayes.network import BayesianNetwork
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.event_trees.forest import Forest
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.linked.elements import LinkedTree
from tracerisk.prm.other_models.linked.model import LinkedModel
from tracerisk.prm.other_models.linked.tree_solution import tree_to_solve


def outcome_trees(
    event_tree: EventTree, trees: Iterable[LinkedTree], *, linked: Iterable[EventTree] = ()
) -> tuple[LinkedTree, ...]:
    """Return a fault tree for each outcome of an event tree, `event tree: outcome`.

    Its top is that a course, once begun, ends so; `TopEvent` of it links the outcome to chains,
    and events that branches share are one event, as in the event tree itself.
    `trees` are the fault trees whose gates and events the conditions name; `linked` the event
    trees that paths lead into.
    Raises ModelError when an event has two values in different trees, and as
    `EventTree.outcome_tree` does.
    """
    by_name = {tree.name: tree for tree in trees}
    made = [tree_to_solve(tree, by_name) for tree in by_name.values()]
    values: dict[str, Expression] = {}
    for solve in made:
        for event, value in zip(solve.tree.events, solve.inputs, strict=True):
            if values.setdefault(event.name, value) != value:
                raise ModelError(
                    f"event tree '{event_tree.name}': event '{event.name}' has different values "
                    "in the fault trees that it joins; rename one"
                )
    forest = Forest.of(solve.tree for solve in made)
    others = tuple(linked)
    outcomes = dict.fromkeys(
        sequence.end_state for tree in (event_tree, *others) for sequence in tree.sequences
    )
    linked_trees = []
    for outcome in outcomes:
        tree = event_tree.outcome_tree(outcome, forest, linked=others)
        linked_trees.append(LinkedTree.of(f"{event_tree.name}: {outcome}", tree, values.items()))
    return tuple(linked_trees)


@dataclass(frozen=True, slots=True)
class FigureGiven:
    """A figure in one joint state of the conditions."""

    states: Mapping[str, str]
    """State of each condition."""
    probability: float
    """Probability of the joint state, given the evidence."""
    figure: Probability
    """Figure in this state, with its complement."""


@dataclass(frozen=True, slots=True)
class FigureOverConditions:
    """A figure over all states of the conditions that bear on its model."""

    cases: tuple[FigureGiven, ...]
    """The joint states, which exclude each other and cover everything."""

    @property
    def figure(self) -> Probability:
        """The sum over the cases of their probability times the figure, in both halves."""
        return mean_of((case.probability, case.figure) for case in self.cases)


def over_conditions(
    model: LinkedModel,
    network: BayesianNetwork,
    figure: str | Expression,
    *,
    evidence: Mapping[str, str] | None = None,
) -> FigureOverConditions:
    """Return a figure of a model whose parameters depend on the conditions of a network.

    The network's events name parameters of the model, which have their figures in each state for
    the whole model at once: trees and chains that share a condition depend on each other by it.
    `evidence` gives known states of conditions.
    Raises ModelError when an event of the network is not a parameter, and as solving and
    `BayesianNetwork.cases` do.
    """
    names = [parameter.name for parameter in model.parameters]
    for name in network.events:
        if name not in names:
            raise ModelError(
                f"the network's event '{name}' is not a parameter of '{model.name}'; "
                f"{one_of(names, name)}"
            )
    cases = network.cases(names, mission_time_h=model.mission_time_h, evidence=evidence)
    return FigureOverConditions(
        tuple(
            FigureGiven(case.states, case.probability, model.solve(case.values).figure(figure))
            for case in cases
        )
    )
