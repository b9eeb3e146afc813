"""The hand calculation: every figure from the failure rate to the mission, with its steps.

Each number is printed with so many digits that the numbers before it give it. The test of this
file recomputes all of them from the text alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from tracerisk.adder.figures.derivation import FunctionDerivation
from tracerisk.prm.hybrid.assessment import FIXED, Assessment
from tracerisk.prm.hybrid.elements import DONE, FunctionState
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.mission_tree import LatentGroup, MissionTree
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.gates import Gate
from tracerisk.report.explain.function import render_derivation
from tracerisk.report.explain.words import number

_EXACT = 1e-9  # relative; closer figures are the same in all digits printed

_INTRODUCTION = """\
# Hand calculation of {name}

From failure rates to the figures of the blocks (part 1), from the blocks to a visit of each
function (part 2), and from the visits to the mission (part 3).

For probabilities as small as these, 1 - exp(-h) is h, and 1 - (1 - a)(1 - b)... is a + b + ..., to
as many digits as the sum is small: of 1e-6, to six. A pocket calculator that has no function
expm1 or log1p needs these; with ten digits it cannot form 1 - (1 - p).
"""


def hand_calculation(
    model: HybridModel,
    assessment: Assessment,
    mission: MissionTree | None,
    derivations: Sequence[FunctionDerivation] | str,
) -> str:
    """Return the calculation as Markdown.

    `derivations` are those of the functions' blocks, or why there are none. The mission's tree is
    `None` for a mission that no static tree holds.
    """
    parts = [
        _INTRODUCTION.format(name=model.name),
        "## 1. From failure rates to the blocks\n",
        *_of_blocks(derivations),
        "## 2. From the blocks to one visit of each function\n",
        "A component of q units, each of which fails with p, fails as soon as m of them have "
        "failed: m = 1: 1 - (1 - p)^q; m = q: p^q; between: the sum of C(q, i) p^i (1 - p)^(q - i) "
        "for i from m to q. A common cause fails all units at once, beside what fails them apart. "
        "A function fails with any of its components: 1 - product of (1 - fails with).\n",
        *(_visit(state) for state in model.states if state.tree.events),
        "## 3. From the visits to the mission\n",
        *_mission(model, assessment, mission),
    ]
    return "\n".join(parts)


def _of_blocks(derivations: Sequence[FunctionDerivation] | str) -> Iterator[str]:
    if isinstance(derivations, str):
        yield f"The blocks are taken as they stand in the sources. {derivations}\n"
        return
    for derivation in derivations:
        yield f"### {derivation.function}\n"
        yield f"```text\n{render_derivation(derivation)}```\n"


def _visit(state: FunctionState) -> str:
    """Return the table of a function: each part of its components, and the whole."""
    first = in_one_visit(state)
    fails = first.tree.node_probabilities(first.probabilities)
    gates = {gate.name: gate for gate in first.tree.gates}
    top = gates[first.tree.top]
    rows = []
    for name in top.inputs:
        rows.append(_part(name, first, fails, gates, level=0))
        inputs = gates[name].inputs if name in gates else ()
        if any(part in gates for part in inputs):  # with a common cause it has parts of its own
            rows += [_part(part, first, fails, gates, level=1) for part in inputs]
    lines = [
        f"### {state.name} in a visit before which nothing has failed\n",
        "| part | units q | fails at m failed | p of a unit | fails with |",
        "|---|---|---|---|---|",
        *rows,
        f"| **{state.name}** | | | | {number(fails[top.name].p)} |\n",
    ]
    return "\n".join(lines)


def _part(
    name: str,
    state: FunctionState,
    fails: Mapping[str, Probability],
    gates: Mapping[str, Gate],
    *,
    level: int,
) -> str:
    """Return the row of a part; `fails` has the probability of each node of the tree."""
    gate, shown, whole = gates.get(name), f"{'- ' * level}{name}", number(fails[name].p)
    if gate is not None and any(part in gates for part in gate.inputs):
        return f"| {shown} | | | | {whole} |"
    events = {event.name: event for event in state.tree.events}
    unit = name if gate is None else gate.inputs[0]
    p = number(state.probabilities[events[unit].parameter])
    n_units, threshold = (1, 1) if gate is None else (len(gate.inputs), gate.threshold)
    return f"| {shown} | {n_units} | {threshold} | {p} | {whole} |"


def _mission(
    model: HybridModel, assessment: Assessment, mission: MissionTree | None
) -> Iterator[str]:
    """Yield the mission as executed, and how the reported reading is related to it."""
    figures = assessment.mission
    if mission is None:
        yield (
            "No static tree holds this mission: it has spares, which fail at another rate once "
            "they work, or nothing that can fail. The chain of `model.json` has the figure "
            f"{number(figures.failure_probability)} ({figures.reading}).\n"
        )
        return
    yield "The visits N that a mission makes where nothing fails, from `next` of the blocks:\n"
    rows = [f"| {name} | {_count(visits)} |" for name, visits in mission.visits.items() if visits]
    yield "\n".join(("| function | visits N |", "|---|---|", *rows, ""))
    yield "What is renewed at each visit fails over the mission with 1 - (1 - p)^N:\n"
    rows = [
        f"| {part.function} | {part.part} | {_count(part.visits)} | {number(part.per_visit)} "
        f"| {number(part.per_mission)} |"
        for part in mission.renewed
    ]
    head = (
        "| function | part | N | p of a visit | fails over the mission |",
        "|---|---|---|---|---|",
    )
    yield "\n".join((*head, *rows, ""))
    if mission.groups:
        yield (
            "Units whose failures stay hidden until the mission ends fail over all visits "
            "together: 1 - product over the functions f of (1 - p_f)^N_f. Their group fails as "
            "soon as so many of them have.\n"
        )
        head = (
            "| component | units q | fails at m failed | N_f x p_f of a unit | one unit fails over "
            "the mission | group fails over the mission |",
            "|---|---|---|---|---|---|",
        )
        rows = [
            f"| {group.component} | {len(group.units)} | {group.least} | "
            f"{_shares(group, mission)} | {number(group.units[0].per_mission)} | "
            f"{number(group.per_mission)} |"
            for group in mission.groups
        ]
        yield "\n".join((*head, *rows, ""))
    yield (
        "**The mission as executed** fails with any of these, 1 - product of (1 - fails over the "
        f"mission) = **{number(mission.probability)}**\n"
    )
    yield from _reading(model, assessment, mission)


def _reading(model: HybridModel, assessment: Assessment, mission: MissionTree) -> Iterator[str]:
    """Yield how the reported figure follows from the mission as executed."""
    figures = assessment.mission
    reported, executed = figures.failure_probability, mission.probability
    off = abs(reported - executed)
    yield f'The report gives {number(reported)}, the reading "{figures.reading}".\n'
    if off <= _EXACT * max(reported, executed):
        yield "That is the same figure.\n"
        return
    whys = " and ".join(_whys(model, figures.reading, mission, off))
    yield (
        f"It differs by {number(off)}, relative {off / max(reported, executed):.2g}"
        f"{f', because {whys}' if whys else ''}; `tracerisk docs theory` prints the formulas.\n"
    )


def _whys(model: HybridModel, reading: str, mission: MissionTree, off: float) -> Iterator[str]:
    """Yield why a figure is by `off` another than that of the mission as executed."""
    if not model.has_cycle:
        yield "branches exclude each other"
        return
    if reading != FIXED:
        yield "the numbers of cycles vary around their mean"
        return
    # Hidden failures make no more of a difference than they are likely at all.
    if sum(float(group.per_mission) for group in mission.groups) >= off:
        yield "hidden failures are carried from cycle to cycle"
    branching = [
        state.name
        for state in model.states
        if sum(step.weight > 0 and step.target != DONE for step in state.next) > 1
    ]
    if branching:
        yield (
            f"a cycle counts the mean of the ways on which {', '.join(branching)} may go on, and "
            "the mission as executed each of them as often as it was gone"
        )


def _shares(group: LatentGroup, mission: MissionTree) -> str:
    """Return how often each function uses a unit of a group, and with which probability."""
    return " + ".join(
        f"{_count(mission.visits[function])} x {number(p)}"
        for function, p in group.units[0].per_visit.items()
    )


def _count(visits: Fraction) -> str:
    return str(visits.numerator) if visits.denominator == 1 else number(float(visits))
