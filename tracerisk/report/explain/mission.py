"""From the figures in blocks to a function and to the mission, as text to check by hand."""

from __future__ import annotations

from collections.abc import Iterator

from tracerisk.prm.hybrid.assessment import FIXED, Assessment
from tracerisk.prm.hybrid.elements import FunctionState
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.part_names import all_units_name
from tracerisk.report.explain.function import aligned_table
from tracerisk.report.explain.words import number


def render_mission(model: HybridModel, assessment: Assessment, function: str) -> str:
    """Return how the blocks make the top event of a function, and that the mission's figure."""
    state = next(
        (function_state for function_state in model.states if function_state.name == function), None
    )
    result = next(
        (
            state_assessment
            for state_assessment in assessment.states
            if state_assessment.name == function
        ),
        None,
    )
    if state is None or result is None:
        return ""
    first = in_one_visit(state)
    top = first.tree.probability(first.probabilities).p
    rows = list(_components(state, first))
    headings, names = ["p of a unit", "fails with"], [row[0] for row in rows]
    lines = [
        "",
        f"{function} fails in a visit before which no unit has failed:",
        *aligned_table(headings, names, [row[1:] for row in rows], None),
        f"  top event, 1 - product of (1 - fails with): {number(top)}",
        "the mission:",
        f"  visits expected: {number(result.expected_visits)}, each failing in the mean with "
        f"{number(result.top_event)}",
        f"  it ends here with their product: {number(result.absorption_probability)}",
        f"  and in any function, the sum of these: {number(assessment.mission.geometric_cycles)}",
    ]
    if assessment.mission.reading == FIXED and model.has_cycle:
        figure = number(assessment.mission.failure_probability)
        lines.append(f"  with fixed numbers of cycles, as `next` counts them: {figure}")
    return "".join(f"{line}\n" for line in lines)


def _components(state: FunctionState, first: FunctionState) -> Iterator[list[str]]:
    """Yield each component's figures, with its own and its common part where it has both."""
    gates = {gate.name: gate for gate in first.tree.gates}
    fails = first.tree.node_probabilities(first.probabilities)
    for name in gates[first.tree.top].inputs:
        of_units = {event.parameter for event in state.tree.events if event.component == name}
        unit = [p for parameter, p in state.probabilities.items() if parameter in of_units]
        yield [name, number(sum(unit)) if unit else "", number(fails[name].p)]
        parts = gates[name].inputs if name in gates else ()
        if all_units_name(name) in parts:
            yield ["  own failures", "", number(fails[parts[0]].p)]
            yield ["  common cause", "", number(fails[parts[1]].p)]
