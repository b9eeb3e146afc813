"""Markov chains and hybrid models as drawings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice

from tracerisk.prm.drawing.layout import Size, layered
from tracerisk.prm.drawing.svg import ALARM, FAINT, PAPER, WORD_HEIGHT, Canvas, word_width
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.hybrid.hybrid import HybridModel

_MOST_BEGUN = 80
_MOST_ENDS = 80
_MOST_ARROWS = 250
_HEIGHT = WORD_HEIGHT + 10.0


@dataclass(frozen=True, slots=True)
class Arrow:
    """How a transition between two states is drawn."""

    label: str
    """Text beside the arrow, such as the transition probability; "" for none."""
    fails: bool = False
    """Whether the arrow leads to a failure state, which makes it dashed and red."""


def chain_svg(
    transitions: Mapping[str, Mapping[str, float]], absorbing: tuple[str, ...], title: str
) -> str:
    """Return the drawing of a chain; of a large one, the first states."""
    sources = list(islice(transitions, _MOST_BEGUN))
    arrows = {
        (state, target): Arrow(f"{p:.4g}")
        for state in sources
        for target, p in transitions[state].items()
        if p > 0.0
    }
    count = len(transitions) + len(absorbing)
    return states_svg(sources, absorbing, arrows, count, title)


def hybrid_svg(model: HybridModel) -> str:
    """Return the drawing of a model: its functions, what follows them, and their failures."""
    failures = model.failure_states
    arrows: dict[tuple[str, str], Arrow] = {}
    for state in model.states[:_MOST_BEGUN]:
        for step in state.next:
            if step.weight > 0:
                label = "" if step.weight == 1 else f"{float(step.weight):.4g}"
                arrows[state.name, step.target] = Arrow(label)
        arrows[state.name, failures[state.name]] = Arrow("", fails=True)
    sources = [state.name for state in model.states[:_MOST_BEGUN]]
    ends = (DONE, *failures.values())
    return states_svg(sources, ends, arrows, len(model.states) + len(ends), model.name)


def states_svg(
    sources: list[str],
    ends: tuple[str, ...],
    arrows: Mapping[tuple[str, str], Arrow],
    count: int,
    title: str,
) -> str:
    """Return the drawing of states from which arrows lead, and of the ends that they reach.

    `count` is how many there are, with those that are left out.
    """
    reached = {target for _, target in arrows}
    absorbing = [name for name in ends if name in reached][:_MOST_ENDS]
    shown = _first([*absorbing, *sources[:_MOST_BEGUN]], arrows)
    sizes = {
        name: Size(word_width(name) + 20.0, _HEIGHT)
        for name in (*sources, *absorbing)
        if name in shown
    }
    drawn = {edge: arrow for edge, arrow in arrows.items() if shown.issuperset(edge)}
    failures = {target for (_, target), arrow in drawn.items() if arrow.fails}
    layout = layered(sizes, drawn, gap=34.0, between=54.0)
    canvas = Canvas()
    for edge, way in layout.ways.items():
        arrow = drawn[edge]
        # A way that was turned runs upwards, beside the one that runs down.
        upwards = way[-1][1] < way[0][1]
        shift = 10.0 if upwards else 0.0
        sides = (_HEIGHT / 2, -_HEIGHT / 2) if not upwards else (-_HEIGHT / 2, _HEIGHT / 2)
        points = [
            (way[0][0] + shift, way[0][1] + sides[0]),
            *((x + shift, y) for x, y in way[1:-1]),
            (way[-1][0] + shift, way[-1][1] + sides[1]),
        ]
        canvas.line(points, arrow=True, stroke=ALARM if arrow.fails else FAINT, dashed=arrow.fails)
        if arrow.label:
            (x, y), (to_x, to_y) = points[0], points[1]
            left = to_x < x and not upwards
            canvas.word(
                x + 0.4 * (to_x - x) + (-3.0 if left else 3.0),
                y + 0.4 * (to_y - y),
                arrow.label,
                anchor="end" if left else "start",
            )
    for name, (x, y) in layout.centres.items():
        width = sizes[name].width
        stroke = ALARM if name in failures else "#222222"
        canvas.box(x, y, width, _HEIGHT, radius=0.0 if name in absorbing else 9.0, stroke=stroke)
        if name in absorbing:
            canvas.box(x, y, width - 6, _HEIGHT - 6, stroke=stroke, fill=PAPER)
        canvas.word(x, y, name)
        if (name, name) in drawn:
            canvas.word(
                x + width / 2 + 2, y - _HEIGHT / 2, f"↻{drawn[name, name].label}", anchor="start"
            )
    height = layout.height
    if count > len(shown):
        height += WORD_HEIGHT
        more = count - len(shown)
        canvas.word(0, height - WORD_HEIGHT / 2, f"{more} more states", anchor="start", fill=FAINT)
    return canvas.svg(layout.width + 30.0, height, title)


def _first(names: list[str], arrows: Mapping[tuple[str, str], Arrow]) -> set[str]:
    """Return as many of the first names as a drawing holds, with the arrows between them."""
    touching: dict[str, list[tuple[str, str]]] = {}
    for edge in arrows:
        for name in dict.fromkeys(edge):
            touching.setdefault(name, []).append(edge)
    shown: set[str] = set()
    count = 0
    for name in names:
        shown.add(name)
        count += sum(shown.issuperset(edge) for edge in touching.get(name, ()))
        if count > _MOST_ARROWS:
            shown.discard(name)
            break
    return shown
