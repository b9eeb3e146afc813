"""The event trees of a logic model, solved over its gates, events and common causes."""

from __future__ import annotations

from tracerisk.errors import ModelError
from tracerisk.prm.other_models.event_trees.forest import Forest
from tracerisk.prm.other_models.event_trees.paths import collected_paths
from tracerisk.prm.other_models.event_trees.solution import EventTreeSolution, solve_event_tree
from tracerisk.prm.other_models.logic.model import LogicModel


def solved_event_trees(
    model: LogicModel, mission_time_h: float, *, common_cause: bool = True
) -> tuple[EventTreeSolution, ...]:
    """Return the solution of each event tree that an initiating event begins, for a mission, [h].

    Trees without one are solved as parts of those that lead into them.
    Members of common cause groups are hit by their common causes in all conditions, unless
    `common_cause` is off.
    Raises ModelError when an event has no figure, a condition is of nothing that there is, or
    the model has substitutions; TooLargeError when a sequence outgrows every budget.
    """
    trees = [event_tree.tree for event_tree in model.event_trees]
    begun = [tree for tree in trees if tree.initiating is not None]
    if begun and model.substitutions:
        raise ModelError(
            f"event tree '{begun[0].name}' is in a model with substitutions, which apply to "
            "fault trees only; remove them, or write them as gates"
        )
    conditions: dict[str, None] = {}
    for tree in begun:
        for path in collected_paths(tree, trees, tree.initiating.name if tree.initiating else ""):
            conditions.update((name, None) for name, _, _ in path.occurrences)
    below = Forest.of(
        model.fault_tree(name, common_cause=common_cause, mission_time_h=mission_time_h)
        for name in conditions
    )
    # A path may set house events that none of its conditions stands above.
    houses = {house.name: house.house for house in model.houses} | dict(below.houses)
    forest = Forest(below.gates, below.events, houses)
    values = forest.values_at(mission_time_h)
    return tuple(solve_event_tree(tree, forest, values, mission_time_h, trees) for tree in begun)
