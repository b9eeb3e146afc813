"""A change of risk as text, for a terminal of 80 columns or none at all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tracerisk.prm.review.change_records import FunctionChange, RiskChange, is_noise
from tracerisk.prm.review.risk_diff import Review, RiskDiff
from tracerisk.report.diff import sentences, titled_lists, wording
from tracerisk.report.tables import filled

_FIGURES = (10, 10, 9)  # the widths of before, after and ratio
_ALONE = 10  # that of a contribution


def render_diff(review: Review, *, width: int = 80) -> str:
    """Return the review as text, its one sentence first; the same for the same input.

    `width` is the number of columns, at least 60; nothing is wider.
    """
    room = max(width, 60)
    lines = []
    for line in (
        *titled_lists.warnings(review),
        *titled_lists.acceptances(review.controllers),
        *titled_lists.verdict_lines(review),
    ):
        lines += _wrapped(line, room, hanging=2)
    lines += [*_wrapped(sentences.headline(review, below_verdicts=True), room), ""]
    if review.controllers:
        lines += [*_wrapped(f"before: {review.before}; after: {review.after}", room), ""]
    for controller in review.controllers:
        lines += _controller(review, controller, room)
    for note in review.notes:
        lines += _wrapped(f"- {note}", room, hanging=2)
    if review.notes:
        lines.append("")
    lines += _wrapped(review.statement, room)
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _controller(review: Review, diff: RiskDiff, room: int) -> Iterator[str]:
    for title, entries in titled_lists.above_figures(review, diff):
        yield from _list(title, entries, room)
    yield from _missions(diff, room)
    if diff.changes and diff.is_comparable:
        yield "  What changed, by what each alone does to mission failure"
        small = wording.small_changes(diff)
        for change in diff.changes:
            if change not in small:
                yield from _change(review, change, room)
        if small:
            text = " " * (_ALONE + 4) + wording.small_line(small, diff)
            yield from _wrapped(text, room, hanging=_ALONE + 4)
        if diff.interaction is not None and wording.has_interaction(diff):
            rest = wording.difference(diff.interaction)
            yield f"  {rest:>{_ALONE}}  what they do only together, and noise"
        yield ""
    if diff.shown_functions:
        yield from _functions(diff, room)
    for title, entries in titled_lists.below_figures(review, diff):
        yield from _list(title, entries, room)
    if diff.within_noise and diff.is_comparable:
        values = "value changes" if diff.within_noise == 1 else "values change"
        yield f"  {diff.within_noise} {values} by {wording.noise(diff)}: reported as unchanged"
        yield ""


def _missions(diff: RiskDiff, room: int) -> Iterator[str]:
    missions = diff.before, diff.after
    cycle = [None if mission is None else mission.cycle_failure_probability for mission in missions]
    figures = {f"  {name}": both for name, both in wording.mission_figures(diff).items()}
    if wording.has_cycles(diff):
        figures["  per cycle"] = (cycle[0], cycle[1])
    rows = [
        (label, (*map(_cell, both), wording.compared(diff, *both)))
        for label, both in figures.items()
    ]
    widths = (*_FIGURES[:2], max(_FIGURES[2], *(len(cells[2]) for _, cells in rows)))
    yield from _row(wording.name_of(diff), ("before", "after", "ratio"), room, widths)
    for label, cells in rows:
        yield from _row(label, cells, room, widths)
    yield ""


def _change(review: Review, change: RiskChange, room: int) -> Iterator[str]:
    lead = f"  {wording.difference(change.contribution):>{_ALONE}}  "
    if change.contribution is None:
        lead = f"  {'?':>{_ALONE}}  "
    undetected = wording.of_undetected(change)
    if change.kind == "failures" and change.contribution == 0.0:
        # It changes what follows failures, not how often they end the mission.
        lead = " " * (_ALONE + 4)
    hanging = _ALONE + 4
    yield from _wrapped(lead + change.summary, room, hanging=hanging)
    why = [
        undetected,
        wording.marks(change),
        wording.causes(change),
        wording.places(review, change),
    ]
    text = "; ".join(part for part in why if part)
    yield from _wrapped(" " * hanging + text, room, hanging=hanging)


def _functions(diff: RiskDiff, room: int) -> Iterator[str]:
    heads = ("before", "after", "ratio" if diff.is_comparable else "")
    yield from _row("  Functions, a visit", heads, room)
    for function_change in diff.shown_functions:
        tops = [
            None if it is None else it.top_event
            for it in (function_change.before, function_change.after)
        ]
        before, after, ratio = _cells(*tops)
        cells = (before, after, ratio if diff.is_comparable else "")
        yield from _row(f"    {_name(diff, function_change)}", cells, room)
        yield from _wrapped(f"      {_visits(function_change)}", room, hanging=6)
    yield ""


def _name(diff: RiskDiff, function: FunctionChange) -> str:
    if function.was is None and function.status in ("added", "removed"):
        return f"{function.name} ({wording.status_of(diff, function)})"
    return wording.name_of(function)


def _visits(function: FunctionChange) -> str:
    before, after = function.before, function.after
    visits = [
        function_figures.expected_visits
        for function_figures in (before, after)
        if function_figures is not None
    ]
    if len(visits) == 2 and is_noise(*visits):
        visits = visits[1:]
    text = " -> ".join(map(wording.count, visits))
    return f"{text} visit" if text == "1" else f"{text} visits"


def _cells(before: float | None, after: float | None) -> tuple[str, str, str]:
    ratio = "" if before is None or after is None else wording.ratio(before, after)
    return _cell(before), _cell(after), ratio


def _cell(figure: float | None) -> str:
    return "-" if figure is None else wording.probability(figure)


def _row(
    label: str, cells: Sequence[str], room: int, widths: Sequence[int] = _FIGURES
) -> Iterator[str]:
    """Yield a label with its cells at the right; a label too long has lines of its own."""
    right = "".join(f"{cell:>{size + 1}}" for cell, size in zip(cells, widths, strict=True))
    left = room - len(right)
    if len(label) > left:
        yield from _wrapped(label, room, hanging=6)
        label = ""
    yield f"{label:<{left}}{right}"


def _list(title: str, entries: Sequence[str], room: int) -> Iterator[str]:
    if entries:
        yield f"  {title}"
        for entry in entries:
            yield from _wrapped(f"  - {entry}", room, hanging=4)
        yield ""


def _wrapped(text: str, room: int, *, hanging: int = 0) -> list[str]:
    return filled(text, room, " " * hanging, breaks_words=True).splitlines()
