"""The fault tree of each function, drawn from left to right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from markupsafe import Markup

from tracerisk.prm.drawing.fault_tree import NEGATED, gate_mark
from tracerisk.prm.drawing.layout import Size, layered
from tracerisk.prm.hybrid.assessment import StateAssessment
from tracerisk.prm.hybrid.elements import FunctionState
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind
from tracerisk.report.html import figures
from tracerisk.report.html.model.leaves import Leaves, leaves_of
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.svg import (
    Drawing,
    Point,
    add_title,
    box,
    circle,
    number,
    text_width,
    word,
)

MOST_NODES = 120
"""How many gates and events a drawing holds: those nearest to the top."""

_ROW = 28.0
_MARK = 30.0
_WORDS = {
    GateKind.AND: "if all of these fail",
    GateKind.OR: "if any of these fails",
}


@dataclass(frozen=True, slots=True)
class _Tree:
    """A function's tree, as the page shows it."""

    name: str
    """Qualified name of the function."""
    probability: str
    """Probability of the top event in one visit, as text."""
    drawing: Markup
    """The drawing as SVG."""
    left_out: int
    """Number of gates and events that the drawing leaves out."""
    outline: tuple[_Outline, ...]
    """The gates of the drawing in words."""
    notes: tuple[str, ...]
    """Remarks on the leaves, one sentence each."""
    has_units: bool
    """Whether some leaves are units of the robot with figures of their own."""


@dataclass(frozen=True, slots=True)
class _Outline:
    """A gate in words, for who does not see the drawing."""

    gate: str
    """Name of the gate."""
    joins: str
    """When the gate fails, in words."""
    inputs: str
    """Labels of the inputs, separated by commas."""


def fault_trees_section(report: ReportInput) -> Section:
    """Return the fault tree of each function, folded, the riskiest unfolded."""
    state_assessments = {state.name: state for state in report.assessment.states}
    trees = [
        _shown(index, state, state_assessments[state.name], leaves_of(report, state))
        for index, state in enumerate(map(in_one_visit, report.model.states))
    ]
    riskiest = max(
        state_assessments.values(),
        key=lambda state_assessment: state_assessment.absorption_probability,
        default=None,
    )
    html = rendered(
        "fault_trees.html.j2",
        trees=trees,
        opened=riskiest.name if riskiest is not None else None,
        has_units=any(tree.has_units for tree in trees),
    )
    return Section("fault-trees", "Fault trees", html)


def _shown(index: int, state: FunctionState, found: StateAssessment, leaves: Leaves) -> _Tree:
    tree = state.tree
    gates = {gate.name: gate for gate in tree.gates}
    names = _uppermost(tree, gates)
    total = len(tree.gates) + len(tree.events) + len(tree.houses)
    outline = tuple(
        _Outline(
            gate.name,
            _text(gate),
            ", ".join(map(leaves.label, gate.inputs)) or "nothing: it never happens",
        )
        for gate in tree.gates
        if gate.name in names
    )
    drawing = _drawn(f"tree-{index + 1}", state, gates, names, leaves)
    top = figures.probability(found.top_event)
    return _Tree(
        name=state.name,
        probability=top,
        drawing=drawing,
        left_out=total - len(names),
        outline=outline,
        notes=leaves.notes,
        has_units=bool(leaves.figures),
    )


def _drawn(
    name: str,
    state: FunctionState,
    gates: Mapping[str, Gate],
    names: Mapping[str, None],
    leaves: Leaves,
) -> Markup:
    tree = state.tree
    figures_of = {
        event.name: leaves.figures.get(event.name, state.probabilities[event.parameter])
        for event in tree.events
    }
    houses = {house.name: house.state for house in tree.houses}
    values = {figure: figures.probability(value) for figure, value in figures_of.items()}
    values |= {text: "happens" if is_so else "never" for text, is_so in houses.items()}
    widths = {
        key: _MARK
        + 14.0
        + text_width(leaves.label(key))
        + (12.0 + text_width(values[key]) if key in values else 0.0)
        for key in names
    }
    edges = [
        (key, child)
        for key in names
        if key in gates
        for child in gates[key].inputs
        if child in names
    ]
    # Laid out from the top down with sides exchanged, so that it runs from left to right.
    layout = layered({key: Size(_ROW, widths[key]) for key in names}, edges, gap=4.0, between=48.0)
    lefts = _lefts(layout.centres, widths)
    drawing = Drawing(
        name,
        f"Fault tree of {state.name}",
        f"{figures.counted(len(tree.gates), 'gate')} over "
        f"{figures.counted(len(tree.events), 'basic event')}. The list below has every gate.",
    )
    for parent, child in edges:
        start = (lefts[parent] + widths[parent], layout.centres[parent][0])
        _draw_edge(drawing, start, (lefts[child], layout.centres[child][0]), f"{parent} {child}")
    for key in names:
        at = (lefts[key], layout.centres[key][0])
        if key in gates:
            hidden = sum(child not in names for child in dict.fromkeys(gates[key].inputs))
            _draw_gate(drawing, at, gates[key], state, hidden)
        else:
            node = drawing.group("node event", event=key, **_data(key, state))
            _draw_event(node, at, leaves.label(key), values[key], is_house=key in houses)
    wide = max((lefts[key] + widths[key] for key in names), default=0.0)
    return drawing.markup(wide + 10.0, layout.width)


def _lefts(centres: Mapping[str, Point], widths: Mapping[str, float]) -> dict[str, float]:
    """Return the left side of each node: those of a column stand flush."""
    sides: dict[float, float] = {}
    for name, (_, y) in centres.items():
        sides[y] = min(sides.get(y, y), y - widths[name] / 2)
    return {name: sides[y] for name, (_, y) in centres.items()}


def _draw_edge(drawing: Drawing, start: Point, end: Point, edge: str) -> None:
    (x, y), (to_x, to_y) = start, end
    bend = to_x - 24.0
    drawing.path(
        f"M{number(x)} {number(y)} H{number(bend)} V{number(to_y)} H{number(to_x)}",
        "edge",
        edge=edge,
    )


def _draw_gate(drawing: Drawing, at: Point, gate: Gate, state: FunctionState, hidden: int) -> None:
    x, y = at
    group = drawing.group("node gate", gate=gate.name, **_data(gate.name, state))
    add_title(group, f"{gate.name}: {_text(gate)}")
    box(group, (x + _MARK / 2, y), _MARK, _ROW - 6.0)
    word(group, x + _MARK / 2, y, gate_mark(gate), "mark")
    if gate.kind in NEGATED:
        circle(group, (x + _MARK, y), 3.0)
    label = gate.name if not hidden else f"{gate.name} (+{hidden})"
    word(group, x + _MARK + 8.0, y, label, "name", "start")


def _draw_event(group: Element, at: Point, name: str, words: str, *, is_house: bool) -> None:
    x, y = at
    add_title(group, f"{name}: {words}")
    if is_house:
        box(group, (x + _MARK / 2, y), 16.0, 16.0)
    else:
        circle(group, (x + _MARK / 2, y), 8.0)
    word(group, x + _MARK + 8.0, y, name, "name", "start")
    word(group, x + _MARK + 20.0 + text_width(name), y, words, "figure", "start")


def _data(name: str, state: FunctionState) -> dict[str, str]:
    """Return what a node stands for: the whole function, or one of its components."""
    if name == state.tree.top:
        return {"function": state.name}
    components = {event.name: event.component for event in state.tree.events}
    gates = {gate.name: gate for gate in state.tree.gates}
    # All that is below a gate, but the top, is of one component.
    while name in gates:
        name = gates[name].inputs[0]
    return {"function": state.name, "component": components.get(name, name)}


def _uppermost(tree: FaultTree, gates: Mapping[str, Gate]) -> dict[str, None]:
    """Return the gates and events nearest to the top, in the order of a walk in breadth."""
    shown = {tree.top: None}
    waiting = [tree.top]
    for name in waiting:
        for child in gates[name].inputs if name in gates else ():
            if len(shown) == MOST_NODES:
                return shown
            if child not in shown:
                shown[child] = None
                waiting.append(child)
    return shown


def _text(gate: Gate) -> str:
    if gate.kind is GateKind.ATLEAST:
        return f"if at least {gate.k} of these fail"
    if gate.kind is GateKind.CARDINALITY:
        return f"if from {gate.k} to {gate.most} of these fail"
    return _WORDS.get(gate.kind, f"by {gate.kind.value} of these")
