"""An event tree as a drawing: a column for each functional event, a row for each path."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tracerisk.prm.drawing.svg import FAINT, WORD_HEIGHT, Canvas, word_width
from tracerisk.prm.other_models.event_trees.elements import End, Fork, Link, Resume, Target
from tracerisk.prm.other_models.event_trees.event_tree import EventTree

_MOST_ROWS = 60
_ROW = WORD_HEIGHT + 8.0
_HEAD = WORD_HEIGHT + 14.0

States = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class _Row:
    """A path through an event tree, drawn as one row."""

    states: States
    """Functional events passed, in order, with the state taken: ((function, state), ...)."""
    sequence: str
    """Name of the sequence that ends the path; `→ NAME` where it links to another tree."""
    end_state: str
    """Name of the end state; equal to `sequence` where it links to another tree."""


def event_tree_svg(tree: EventTree) -> str:
    """Return the drawing of an event tree; of more than 60 paths, the first ones.

    Paths that go on in another event tree end with its name.
    """
    rows: list[_Row] = []
    more = False
    for row in _rows(tree):
        if len(rows) == _MOST_ROWS:
            more = True
            break
        rows.append(row)
    functions = [
        name
        for name in tree.functional_events
        if any(name == function for row in rows for function, _ in row.states)
    ]
    words = {
        name: {state for row in rows for f, state in row.states if f == name} for name in functions
    }
    left: dict[str, float] = {}
    begun = tree.initiating.name if tree.initiating else tree.name
    x = word_width(begun) + 16.0
    for name in functions:
        left[name] = x
        x += max(word_width(name), *(word_width(state) + 22.0 for state in words[name])) + 18.0
    ends = x + max((word_width(row.sequence) for row in rows), default=0.0) + 24.0
    width = ends + max((word_width(row.end_state) for row in rows), default=0.0)
    canvas = Canvas()
    canvas.word(0.0, WORD_HEIGHT / 2, begun, anchor="start")
    for name in functions:
        canvas.word(left[name], WORD_HEIGHT / 2, name, anchor="start")
    canvas.line([(0.0, _HEAD - 8.0), (width, _HEAD - 8.0)], stroke=FAINT)
    levels = _levels(rows)
    canvas.line([(0.0, levels[()]), (_next(rows, (), left, x), levels[()])])
    for states, y in levels.items():
        if not states:
            continue
        function, state = states[-1]
        start = left[function]
        canvas.line([(start, levels[states[:-1]]), (start, y), (_next(rows, states, left, x), y)])
        canvas.word(start + 6.0, y - WORD_HEIGHT / 2 + 1.0, state, anchor="start", fill=FAINT)
    for rank, row in enumerate(rows):
        y = _HEAD + (rank + 0.5) * _ROW
        canvas.word(x + 6.0, y, row.sequence, anchor="start")
        if row.end_state != row.sequence:
            canvas.word(ends, y, row.end_state, anchor="start")
    height = _HEAD + len(rows) * _ROW
    if more:
        canvas.word(0.0, height + WORD_HEIGHT / 2, "and more paths", anchor="start", fill=FAINT)
        height += WORD_HEIGHT
    return canvas.svg(width, height, f"Event tree {tree.name}")


def _rows(tree: EventTree) -> Iterator[_Row]:
    waiting: list[tuple[Target, States]] = [(tree.start.target, ())]
    while waiting:
        target, states = waiting.pop()
        match target:
            case End(name):
                yield _Row(states, name, tree.sequence(name).end_state)
            case Link(name):
                yield _Row(states, f"→ {name}", f"→ {name}")
            case Resume(name):
                waiting.append((tree.branch(name).target, states))
            case Fork(function, paths):
                waiting.extend(
                    (path.target, (*states, (function, path.state))) for path in reversed(paths)
                )


def _levels(rows: list[_Row]) -> dict[States, float]:
    """Return how far down each part of a path runs: amid the paths that begin with it."""
    spans: dict[States, tuple[int, int]] = {(): (0, len(rows) - 1)}
    for rank, row in enumerate(rows):
        for length in range(1, len(row.states) + 1):
            part = row.states[:length]
            spans[part] = (spans.get(part, (rank, rank))[0], rank)
    return {
        part: _HEAD + ((first + last) / 2 + 0.5) * _ROW for part, (first, last) in spans.items()
    }


def _next(rows: list[_Row], states: States, left: dict[str, float], end: float) -> float:
    """Return where the part of a path that took `states` forks, or ends."""
    for row in rows:
        if row.states[: len(states)] == states:
            further = row.states[len(states) :]
            return left[further[0][0]] if further else end
    return end
