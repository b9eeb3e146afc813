"""The Markov chain over the functions, drawn and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from markupsafe import Markup

from tracerisk.prm.assessment import StateAssessment
from tracerisk.prm.drawing.layout import Size, layered
from tracerisk.prm.hybrid import DONE, HybridModel
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.svg import Drawing, Point, box, number, tell, text_width, word
from tracerisk.report.html.tables import Cell, Column, Row, Table

MOST_STATES = 60
"""How many functions a drawing holds; the table has all of them."""

_HEIGHT = 34.0
_PADDING = 26.0
_LABEL = 18.0
_ASIDE = 112.0
"""Between a state and its failure, for the probability."""


@dataclass(frozen=True, slots=True)
class _Arrow:
    """A transition: what is written at it, whether it fails, its share of all that follows."""

    label: str
    told: str
    fails: bool = False


@dataclass(frozen=True, slots=True)
class _Places:
    """Where states are, how ways run, and the extent.

    `lanes` are those of the ways back, `beside` the room that a failure has across.
    """

    centres: Mapping[str, Point]
    ways: Mapping[tuple[str, str], tuple[Point, ...]]
    lanes: Mapping[tuple[str, str], float]
    beside: float
    width: float
    height: float


def chain_section(report: ReportInput) -> Section:
    """Return the chain's drawing and its transitions as a table."""
    model, assessment = report.model, report.assessment
    states = {state.name: state for state in assessment.states}
    shown = model.states[:MOST_STATES]
    drawing = _drawn(model, states)
    html = rendered(
        "chain.html.j2",
        drawing=drawing,
        left_out=len(model.states) - len(shown),
        shown=len(shown),
        table=_transitions(model, states),
        has_cycle=model.has_cycle,
    )
    return Section("chain", "Markov chain", html)


def _arrows(
    model: HybridModel, states: dict[str, StateAssessment]
) -> dict[tuple[str, str], _Arrow]:
    shown = model.states[:MOST_STATES]
    names = {state.name for state in shown} | {DONE}
    arrows: dict[tuple[str, str], _Arrow] = {}
    for state in shown:
        top = states[state.name].top_event
        for step in state.next:
            if step.weight > 0 and step.target in names:
                told = f"{state.name} to {step.target}: {_onward(top, step.weight)}"
                label = f"{float(step.weight):.4g}"
                arrows[state.name, step.target] = _Arrow(label, told)
        failure = states[state.name].failure_state
        told = f"{state.name} to {failure}: {top:.6g}"
        arrows[state.name, failure] = _Arrow(figures.probability(top), told, fails=True)
    return arrows


def _drawn(model: HybridModel, states: dict[str, StateAssessment]) -> Markup:
    shown = model.states[:MOST_STATES]
    arrows = _arrows(model, states)
    ends = [DONE] if any(target == DONE for _, target in arrows) else []
    names = [*(state.name for state in shown), *ends]
    failures = {state.name: states[state.name].failure_state for state in shown}
    places = _placed(names, failures, arrows)
    drawing = Drawing(
        "chain-drawing",
        f"Markov chain of {model.name}",
        f"{figures.counted(len(model.states), 'function')}, each of which goes on to what "
        "follows it, or fails and ends the mission. The table below has every transition.",
    )
    labels: list[tuple[Point, _Arrow]] = []
    for edge, arrow in arrows.items():
        if arrow.fails:
            at = _draw_failing(drawing, edge, places)
        elif edge[0] == edge[1]:
            at = _draw_loop(drawing, edge[0], places)
        elif edge in places.lanes:
            at = _draw_back(drawing, edge, places)
        else:
            at = _draw_way(drawing, edge, places.ways[edge])
        labels.append((at, arrow))
    for name in names:
        _draw_state(drawing, name, places, is_entry=name == model.entry)
    for failure in failures.values():
        _draw_end(drawing, failure, places, "node end failing")
    for at, arrow in labels:
        _draw_label(drawing, at, arrow)
    return drawing.markup(places.width, places.height, above=20.0)


def _placed(
    names: Sequence[str],
    failures: Mapping[str, str],
    arrows: Mapping[tuple[str, str], _Arrow],
) -> _Places:
    """Lay the states out from the top down, each with its failure at its right.

    All take the same room, so that what follows one another stands in a line. Ways back, to a
    state that came earlier, run in lanes of their own at the left.
    """
    width = max(text_width(name) for name in names) + _PADDING
    beside = max((text_width(name) for name in failures.values()), default=0.0) + _PADDING
    room = width + _ASIDE + beside
    rank = {name: index for index, name in enumerate(names)}
    onward = [edge for edge, arrow in arrows.items() if not arrow.fails and edge[0] != edge[1]]
    back = [edge for edge in onward if rank[edge[1]] < rank[edge[0]]]
    layout = layered(
        dict.fromkeys(names, Size(room, _HEIGHT)),
        [edge for edge in onward if edge not in set(back)],
        gap=40.0,
        between=50.0,
    )
    lanes = _lanes(back, {name: y for name, (_, y) in layout.centres.items()})
    lane_room = max((text_width(arrows[edge].label) for edge in back), default=0.0) + 14.0
    loops = 50.0 if any(source == target for source, target in arrows) else 0.0
    aside = loops + (max(lanes.values()) + 1) * lane_room if lanes else loops
    left = aside + (width - room) / 2
    centres = {name: (x + left, y) for name, (x, y) in layout.centres.items()}
    for name, failure in failures.items():
        x, y = centres[name]
        centres[failure] = (x + (width + beside) / 2 + _ASIDE, y)
    ways = {edge: tuple((x + left, y) for x, y in way) for edge, way in layout.ways.items()}
    at = {edge: aside - loops - (lane + 0.5) * lane_room for edge, lane in lanes.items()}
    return _Places(centres, ways, at, beside, aside + layout.width, layout.height + 20.0)


def _lanes(
    back: Sequence[tuple[str, str]], heights: Mapping[str, float]
) -> dict[tuple[str, str], int]:
    """Return the lane of each way back, 0 the innermost; the shortest stand innermost."""
    lanes: dict[tuple[str, str], int] = {}
    for edge in sorted(back, key=lambda each: heights[each[0]] - heights[each[1]]):
        lower, upper = heights[edge[0]], heights[edge[1]]
        taken = {
            lane
            for (source, target), lane in lanes.items()
            if heights[target] <= lower and heights[source] >= upper
        }
        lanes[edge] = next(lane for lane in range(len(back)) if lane not in taken)
    return lanes


def _draw_way(drawing: Drawing, edge: tuple[str, str], way: tuple[Point, ...]) -> Point:
    """Draw a transition and return where its probability is written."""
    points = [
        (way[0][0], way[0][1] + _HEIGHT / 2),
        *way[1:-1],
        (way[-1][0], way[-1][1] - _HEIGHT / 2),
    ]
    drawing.curve(points, "edge", arrow=True, edge=f"{edge[0]} {edge[1]}", function=edge[0])
    (x, y), (to_x, to_y) = points[0], points[1]
    return ((x + to_x) / 2, (y + to_y) / 2)


def _draw_back(drawing: Drawing, edge: tuple[str, str], places: _Places) -> Point:
    """Draw a way back: below its state, up in its lane, and into the earlier state from above."""
    (x, y), (to_x, to_y) = places.centres[edge[0]], places.centres[edge[1]]
    lane, bend = places.lanes[edge], 8.0
    low, high = y + _HEIGHT / 2 + 14.0, to_y - _HEIGHT / 2 - 14.0
    x, to_x = x - 12.0, to_x - 12.0
    n = number
    drawing.path(
        f"M{n(x)} {n(y + _HEIGHT / 2)} V{n(low - bend)} Q{n(x)} {n(low)} {n(x - bend)} {n(low)} "
        f"H{n(lane + bend)} Q{n(lane)} {n(low)} {n(lane)} {n(low - bend)} "
        f"V{n(high + bend)} Q{n(lane)} {n(high)} {n(lane + bend)} {n(high)} "
        f"H{n(to_x - bend)} Q{n(to_x)} {n(high)} {n(to_x)} {n(high + bend)} "
        f"V{n(to_y - _HEIGHT / 2)}",
        "edge",
        arrow=True,
        edge=f"{edge[0]} {edge[1]}",
        function=edge[0],
    )
    return (lane, (low + high) / 2)


def _draw_failing(drawing: Drawing, edge: tuple[str, str], places: _Places) -> Point:
    """Draw the way into a state's failure, and return where its probability is written."""
    (x, y), (to_x, _) = places.centres[edge[0]], places.centres[edge[1]]
    start, end = x + (text_width(edge[0]) + _PADDING) / 2, to_x - places.beside / 2
    drawing.path(
        f"M{number(start)} {number(y)} H{number(end)}",
        "edge failing",
        arrow=True,
        edge=f"{edge[0]} {edge[1]}",
        function=edge[0],
    )
    # In a column, whatever the states are called.
    return (end - _ASIDE / 2 - 2.0, y)


def _draw_loop(drawing: Drawing, name: str, places: _Places) -> Point:
    """Draw a way from a state to itself, at its left."""
    x, y = places.centres[name]
    x -= (text_width(name) + _PADDING) / 2
    drawing.path(
        f"M{number(x)} {number(y - 8)} C{number(x - 38)} {number(y - 24)} "
        f"{number(x - 38)} {number(y + 24)} {number(x)} {number(y + 8)}",
        "edge",
        arrow=True,
        edge=f"{name} {name}",
        function=name,
    )
    return (x - 30.0, y)


def _draw_state(drawing: Drawing, name: str, places: _Places, *, is_entry: bool) -> None:
    if name == DONE:
        _draw_end(drawing, name, places, "node end")
        return
    group = drawing.group("node entry" if is_entry else "node", state=name, function=name)
    tell(group, f"{name}, where a mission begins" if is_entry else name)
    centre = places.centres[name]
    box(group, centre, text_width(name) + _PADDING, _HEIGHT)
    word(group, *centre, name, "name")


def _draw_end(drawing: Drawing, name: str, places: _Places, kind: str) -> None:
    group = drawing.group(kind, state=name)
    x, y = places.centres[name]
    width = text_width(name) + _PADDING
    # Failures stand flush at their left, where the arrow ends.
    x += 0.0 if name == DONE else (width - places.beside) / 2
    box(group, (x, y), width, _HEIGHT)
    box(group, (x, y), width - 6.0, _HEIGHT - 6.0, "shape inner")
    word(group, x, y, name, "name")


def _draw_label(drawing: Drawing, at: Point, arrow: _Arrow) -> None:
    group = drawing.group("label failing" if arrow.fails else "label")
    tell(group, arrow.told)
    box(group, at, text_width(arrow.label) + 8.0, _LABEL, "ground")
    word(group, *at, arrow.label, "figure")


def _onward(top: float, weight: Fraction) -> str:
    return f"{(1.0 - top) * float(weight):.6g}"


def _transitions(model: HybridModel, states: dict[str, StateAssessment]) -> Table:
    rows = []
    for state in model.states:
        found = states[state.name]
        steps = [step for step in state.next if step.weight > 0]
        ways = [
            *(
                (each.target, _onward(found.top_event, each.weight), str(each.weight))
                for each in steps
            ),
            (found.failure_state, figures.probability(found.top_event), figures.NOTHING),
        ]
        rows += [Row((Cell(state.name), *map(Cell, way)), state.name) for way in ways]
    return Table(
        "transitions",
        "Every transition of the chain",
        (
            Column("from"),
            Column("to"),
            Column("probability", is_number=True),
            Column("share of what follows", is_number=True),
        ),
        tuple(rows),
    )
