"""What changed since an earlier version, in the words of `tracerisk diff`."""

from __future__ import annotations

from dataclasses import dataclass

from tracerisk.prm.hybrid.assessment import MissionFigures
from tracerisk.prm.review.risk_change import FunctionFigures, Review, RiskDiff
from tracerisk.report.diff import sentences
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import Cell, Column, Row, Table, numbers, texts

_NONE = "none"


@dataclass(frozen=True, slots=True)
class _Controller:
    """What is shown of one controller: its name, tables, and lines below them."""

    name: str
    tables: tuple[Table, ...]
    lines: tuple[str, ...]


def difference_section(report: ReportInput) -> Section | None:
    """Return the difference to an earlier version; `None` where none was asked for."""
    review = report.review
    if review is None:
        return None
    html = rendered(
        "difference.html.j2",
        headline=sentences.headline(review),
        before=review.before,
        after=review.after,
        controllers=[
            _controller(review, index, each) for index, each in enumerate(review.controllers)
        ],
        notes=review.notes,
    )
    return Section("difference", f"Since {review.before}", html)


def _controller(review: Review, index: int, diff: RiskDiff) -> _Controller:
    name = f"difference-{index + 1}"
    tables = [_missions(name, review, diff)]
    if diff.changes:
        tables.append(_changes(name, review, diff))
    if any(each.status != "unchanged" for each in diff.functions):
        tables.append(_functions(name, diff))
    lines = [
        f"{point.component} is a single point of failure now, in {sentences.some(point.functions)}"
        for point in diff.single_points
    ]
    lines += [
        f"{sentences.pin(pin)} ({review.place(pin.location, is_gone=pin.kind == 'removed')})"
        for pin in diff.pins
    ]
    lines += (*diff.of_run, *diff.inputs)
    if diff.within_noise:
        lines.append(
            f"values that changed by less than 1 %, reported as unchanged: {diff.within_noise}"
        )
    shown = diff.name if diff.was is None else f"{diff.name} (was {diff.was})"
    return _Controller(shown, tuple(tables), tuple(lines))


def _missions(name: str, review: Review, diff: RiskDiff) -> Table:
    old, new = diff.before, diff.after
    kinds = {
        "mission failure": "failure_probability",
        "failure per cycle": "cycle_failure_probability",
        "expected cycles": "expected_cycles",
    }
    rows = tuple(
        Row(
            (
                Cell(label),
                Cell(_figure(old, kind)),
                Cell(_figure(new, kind)),
                Cell(
                    ""
                    if old is None or new is None
                    else sentences.ratio(getattr(old, kind), getattr(new, kind))
                ),
            )
        )
        for label, kind in kinds.items()
    )
    columns = (Column("figure"), *numbers(review.before, review.after, "ratio"))
    return Table(f"{name}-mission", "The mission", columns, rows)


def _changes(name: str, review: Review, diff: RiskDiff) -> Table:
    rows = [
        Row(
            (
                Cell(change.summary, note=sentences.marks(change)),
                Cell(sentences.difference(change.contribution)),
                Cell(sentences.causes(change)),
                Cell(sentences.places(review, change)),
            ),
            component=change.component,
        )
        for change in diff.changes
    ]
    if diff.interaction is not None:
        text = "what they do only together, and noise"
        rows.append(
            Row((Cell(text), Cell(sentences.difference(diff.interaction)), Cell(""), Cell("")))
        )
    columns = (
        Column("change"),
        Column("alone", "what only it does to mission failure", is_number=True),
        *texts("cause", "where"),
    )
    return Table(f"{name}-changes", "What changed", columns, tuple(rows))


def _functions(name: str, diff: RiskDiff) -> Table:
    rows = tuple(
        Row(
            (
                Cell(
                    each.name if each.was is None else f"{each.name} (was {each.was})",
                    note=each.status,
                ),
                *_of_function(each.before),
                *_of_function(each.after),
            ),
            function=each.name,
        )
        for each in diff.functions
        if each.status != "unchanged"
    )
    columns = (
        Column("function"),
        Column("fails in a visit", "before", is_number=True),
        Column("visits", "before", is_number=True),
        Column("fails in a visit", "after", is_number=True),
        Column("visits", "after", is_number=True),
    )
    return Table(f"{name}-functions", "Functions", columns, rows)


def _figure(mission: MissionFigures | None, kind: str) -> str:
    if mission is None:
        return _NONE
    value = getattr(mission, kind)
    return sentences.count(value) if kind == "expected_cycles" else sentences.probability(value)


def _of_function(function: FunctionFigures | None) -> tuple[Cell, Cell]:
    if function is None:
        return Cell(_NONE), Cell(_NONE)
    return Cell(sentences.probability(function.top_event)), Cell(
        sentences.count(function.expected_visits)
    )
