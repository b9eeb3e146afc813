"""The Markov chain over the functions, drawn and as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from markupsafe import Markup

from tracerisk.prm.hybrid.assessment import StateAssessment
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.svg import Drawing, Point, add_title, box, number, text_width, word
from tracerisk.report.html.tables import Table, numbers, row_of, texts

Edge = tuple[str, str]

MOST_STATES = 60
"""How many functions a drawing holds; the table has all of them."""

_HEIGHT = 34.0
_PITCH = 82.0
_LANE = 16.0
"""Between the labels of two lanes."""
_LABEL = 18.0
_LONGEST_FRACTION = 7
"""How many characters a share has as a fraction, as the blocks have it; longer ones are decimal."""
_ASIDE = 112.0
"""Between a state and its failure, for the probability."""


@dataclass(frozen=True, slots=True)
class _Arrow:
    """How a transition is drawn."""

    label: str
    """Text beside the arrow: a share or a probability."""
    title: str
    """Text shown when pointed at: from, to and probability."""
    fails: bool = False
    """Whether the arrow leads to a failure state."""


@dataclass(frozen=True, slots=True)
class _Places:
    """Where the parts of the drawing are; x to the right and y down."""

    centres: Mapping[str, Point]
    """Centre (x, y) of each state by name [px]."""
    lanes: Mapping[Edge, tuple[float, float, float]]
    """Ways that do not lead straight down, (x of the lane, y where it leaves, y where it
    arrives) by (source, target) [px]."""
    beside: float
    """Width of the column of failure states [px]."""
    width: float
    """Horizontal extent of the drawing [px]."""
    height: float
    """Vertical extent of the drawing [px]."""


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


def _arrows(model: HybridModel, states: dict[str, StateAssessment]) -> dict[Edge, _Arrow]:
    shown = model.states[:MOST_STATES]
    names = {state.name for state in shown} | {DONE}
    arrows: dict[Edge, _Arrow] = {}
    for state in shown:
        top = states[state.name].top_event
        for step in state.next:
            if step.weight > 0 and step.target in names:
                text = f"{state.name} to {step.target}: {_onward(top, step.weight)}"
                label = str(step.weight)
                if len(label) > _LONGEST_FRACTION:
                    label = f"{float(step.weight):.4g}"
                arrows[state.name, step.target] = _Arrow(label, text)
        failure = states[state.name].failure_state
        text = f"{state.name} to {failure}: {top:.6g}"
        arrows[state.name, failure] = _Arrow(figures.probability(top), text, fails=True)
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
        elif edge in places.lanes:
            at = _draw_around(drawing, edge, places)
        else:
            at = _draw_onward(drawing, edge, places)
        labels.append((at, arrow))
    for name in names:
        _draw_state(drawing, name, places, is_entry=name == model.entry)
    for failure in failures.values():
        _draw_end(drawing, failure, places, "node end failing")
    for at, arrow in labels:
        _draw_label(drawing, at, arrow)
    return drawing.markup(places.width, places.height)


def _placed(
    names: Sequence[str], failures: Mapping[str, str], arrows: Mapping[Edge, _Arrow]
) -> _Places:
    """Put the states below each other in their order, each with its failure at its right.

    A way to the next state leads straight down; every other has a lane at the left.
    """
    rank = {name: index for index, name in enumerate(names)}
    around = [
        edge
        for edge, arrow in arrows.items()
        if not arrow.fails and rank[edge[1]] != rank[edge[0]] + 1
    ]
    lanes = _lanes([(rank[source], rank[target]) for source, target in around])
    room = max((text_width(arrows[edge].label) for edge in around), default=0.0) + _LANE
    left = (max(lanes) + 1) * room if lanes else 0.0
    width = max(map(_width, names))
    beside = max(map(_width, failures.values()), default=0.0)
    middle = left + width / 2
    centres = {name: (middle, _HEIGHT / 2 + index * _PITCH) for name, index in rank.items()}
    for name, failure in failures.items():
        right = left + width + _ASIDE + beside / 2
        centres[failure] = (right, centres[name][1])
    leaves, arrives = _ports(around, lanes, centres)
    ways = {
        edge: (left - (lane + 0.5) * room, leaves[edge], arrives[edge])
        for edge, lane in zip(around, lanes, strict=True)
    }
    height = (len(names) - 1) * _PITCH + _HEIGHT
    return _Places(centres, ways, beside, left + width + _ASIDE + beside, height)


def _lanes(spans: Sequence[tuple[int, int]]) -> list[int]:
    """Return a lane for each span of ranks, 0 the innermost, so that those of one lie apart.

    The shortest come first, and so stand inside the longer ones.
    """
    lanes: dict[int, int] = {}
    for index in sorted(
        range(len(spans)), key=lambda number: abs(spans[number][0] - spans[number][1])
    ):
        low, high = sorted(spans[index])
        taken = {
            lane
            for other, lane in lanes.items()
            if min(spans[other]) <= high and max(spans[other]) >= low
        }
        lanes[index] = next(lane for lane in range(len(spans)) if lane not in taken)
    return [lanes[index] for index in range(len(spans))]


def _ports(
    around: Sequence[Edge], lanes: Sequence[int], centres: Mapping[str, Point]
) -> tuple[dict[Edge, float], dict[Edge, float]]:
    """Return how high each way leaves its state, below its middle, and arrives, above it."""
    ordered = [edge for _, edge in sorted(zip(lanes, around, strict=True))]
    ports: tuple[dict[Edge, float], dict[Edge, float]] = ({}, {})
    for end, sign in ((0, 1.0), (1, -1.0)):
        for name in centres:
            here = [edge for edge in ordered if edge[end] == name]
            for index, edge in enumerate(here):
                # The innermost lane has the port nearest to the middle.
                offset = (index + 0.5) / len(here) * (_HEIGHT / 2 - 4.0) + 2.0
                ports[end][edge] = centres[name][1] + sign * offset
    return ports


def _draw_arrow(drawing: Drawing, way: str, kind: str, edge: Edge) -> None:
    drawing.path(way, kind, arrow=True, edge=f"{edge[0]} {edge[1]}", function=edge[0])


def _draw_onward(drawing: Drawing, edge: Edge, places: _Places) -> Point:
    """Draw the way to the next state, and return where its share is written."""
    (x, y), (_, to_y) = places.centres[edge[0]], places.centres[edge[1]]
    start, end = y + _HEIGHT / 2, to_y - _HEIGHT / 2
    _draw_arrow(drawing, f"M{number(x)} {number(start)} V{number(end)}", "edge", edge)
    return (x, (start + end) / 2 - 2.0)


def _draw_around(drawing: Drawing, edge: Edge, places: _Places) -> Point:
    """Draw a way in its lane, from the left of its state to the left of the other."""
    lane, start, end = places.lanes[edge]
    x, to_x = (places.centres[name][0] - _width(name) / 2 for name in edge)
    bend = min(7.0, abs(end - start) / 2)
    turn = bend if end > start else -bend
    n = number
    _draw_arrow(
        drawing,
        f"M{n(x)} {n(start)} H{n(lane + bend)} Q{n(lane)} {n(start)} {n(lane)} {n(start + turn)} "
        f"V{n(end - turn)} Q{n(lane)} {n(end)} {n(lane + bend)} {n(end)} H{n(to_x)}",
        "edge",
        edge,
    )
    return (lane, _free_height(edge, places))


def _free_height(edge: Edge, places: _Places) -> float:
    """Return where in a lane no way of an outer lane crosses, as near to the middle as can be."""
    lane, start, end = places.lanes[edge]
    crossing = [
        height
        for other, (x, *ends) in places.lanes.items()
        if other != edge and x < lane
        for height in ends
    ]
    shares = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)
    heights = [start + share * (end - start) for share in shares]
    room = [min((abs(value - at) for at in crossing), default=_LABEL) for value in heights]
    best = max(min(value, _LABEL) for value in room)
    return next(at for at, value in zip(heights, room, strict=True) if min(value, _LABEL) == best)


def _draw_failing(drawing: Drawing, edge: Edge, places: _Places) -> Point:
    """Draw the way into a state's failure, and return where its probability is written."""
    (x, y), (to_x, _) = places.centres[edge[0]], places.centres[edge[1]]
    start, end = x + _width(edge[0]) / 2, to_x - places.beside / 2
    _draw_arrow(drawing, f"M{number(start)} {number(y)} H{number(end)}", "edge failing", edge)
    # In a column, whatever the states are called.
    return (end - _ASIDE / 2 - 2.0, y)


def _draw_state(drawing: Drawing, name: str, places: _Places, *, is_entry: bool) -> None:
    if name == DONE:
        _draw_end(drawing, name, places, "node end")
        return
    group = drawing.group("node entry" if is_entry else "node", state=name, function=name)
    add_title(group, f"{name}, where a mission begins" if is_entry else name)
    centre = places.centres[name]
    box(group, centre, _width(name), _HEIGHT)
    word(group, *centre, name, "name")


def _draw_end(drawing: Drawing, name: str, places: _Places, kind: str) -> None:
    group = drawing.group(kind, state=name)
    x, y = places.centres[name]
    width = _width(name)
    # Failures stand flush at their left, where the arrow ends.
    x += 0.0 if name == DONE else (width - places.beside) / 2
    box(group, (x, y), width, _HEIGHT)
    box(group, (x, y), width - 6.0, _HEIGHT - 6.0, "shape inner")
    word(group, x, y, name, "name")


def _draw_label(drawing: Drawing, at: Point, arrow: _Arrow) -> None:
    group = drawing.group("label failing" if arrow.fails else "label")
    add_title(group, arrow.title)
    box(group, at, text_width(arrow.label) + 8.0, _LABEL, "ground")
    word(group, *at, arrow.label, "figure")


def _width(name: str) -> float:
    return text_width(name) + 26.0


def _onward(top: float, weight: Fraction) -> str:
    return f"{(1.0 - top) * float(weight):.6g}"


def _transitions(model: HybridModel, states: dict[str, StateAssessment]) -> Table:
    rows = []
    for state in model.states:
        state_assessment = states[state.name]
        steps = [step for step in state.next if step.weight > 0]
        ways = [
            *(
                (
                    next_step.target,
                    _onward(state_assessment.top_event, next_step.weight),
                    str(next_step.weight),
                )
                for next_step in steps
            ),
            (
                state_assessment.failure_state,
                figures.probability(state_assessment.top_event),
                figures.NOTHING,
            ),
        ]
        rows += [row_of(state.name, *way, function=state.name) for way in ways]
    return Table(
        "transitions",
        "Every transition of the chain",
        (*texts("from", "to"), *numbers("probability", "share of what follows")),
        tuple(rows),
    )
