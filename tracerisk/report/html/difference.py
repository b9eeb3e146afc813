"""What changed since an earlier version, in the words of `tracerisk diff`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from tracerisk.prm.hybrid.assessment import MissionFigures
from tracerisk.prm.review.change_records import FunctionFigures
from tracerisk.prm.review.risk_diff import Review, RiskDiff
from tracerisk.report.diff import sentences, titled_lists, wording
from tracerisk.report.html.page import asset, rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Data, Section
from tracerisk.report.html.sources import ChangedLines, changed_lines, line_links
from tracerisk.report.html.tables import Cell, Column, Table, numbers, row_of, texts

_MOST_CHANGED = 12  # places of the sources that are listed
_NONE = "none"
_NOT_KNOWN = "not known"


@dataclass(frozen=True, slots=True)
class _Controller:
    """What is shown of one controller."""

    name: str
    """Path of the controller, with the earlier one where it was moved."""
    tables: tuple[Table, ...]
    """Tables of the mission, the changes and the functions."""
    lists: tuple[tuple[str, list[str]], ...]
    """What is said below the tables: each list with its title."""
    note: str
    """How many values are left out as unchanged; empty for none."""


def difference_section(report: ReportInput) -> Section | None:
    """Return the difference to an earlier version; `None` where none was asked for."""
    review = report.review
    if review is None:
        return None
    sources = report.compared_sources
    changed = [] if sources is None else list(changed_lines(sources, line_links(report.sources)))
    runs, data = _both_runs(report, review, changed)
    html = rendered(
        "difference.html.j2",
        headline=sentences.whole_headline(review),
        before=review.before,
        after=review.after,
        controllers=[
            _controller(review, index, controller)
            for index, controller in enumerate(review.controllers)
        ],
        notes=review.notes,
        both_runs=runs,
        has_runs=bool(data),
        changed_lines=_changed(changed),
    )
    return Section(
        "difference",
        f"Since {review.before}",
        html,
        css=asset("changed_lines.css") + (asset("side_by_side.css") if data else ""),
        js=asset("side_by_side.js") if data else "",
        data=data,
    )


def _changed(changed: Sequence[ChangedLines]) -> Markup | str:
    """Return the lines of the sources that differ; empty for none."""
    if not changed:
        return ""
    return rendered(
        "changed_lines.html.j2",
        changed=changed[:_MOST_CHANGED],
        more=max(len(changed) - _MOST_CHANGED, 0),
    )


def _both_runs(
    report: ReportInput, review: Review, changed: Sequence[ChangedLines]
) -> tuple[Markup | str, tuple[Data, ...]]:
    """Return both runs side by side with their data, or a sentence that says why not."""
    shown = report.both_runs
    if isinstance(shown, str):
        return f"Both runs are not shown side by side. {shown}" if shown else "", ()
    from tracerisk.report.html.run.side_by_side import side_by_side

    return side_by_side(shown, report, changed, review.renamed)


def _controller(review: Review, index: int, diff: RiskDiff) -> _Controller:
    name = f"difference-{index + 1}"
    tables = [_missions(name, review, diff)]
    if diff.changes and diff.is_comparable:
        tables.append(_changes(name, review, diff))
    if diff.shown_functions:
        tables.append(_functions(name, diff))
    lists = [
        *titled_lists.above_figures(review, diff),
        *titled_lists.below_figures(review, diff),
    ]
    note = ""
    if diff.within_noise and diff.is_comparable:
        note = f"Values that changed by {wording.noise(diff)}, reported as unchanged: "
        note += f"{diff.within_noise}."
    return _Controller(wording.name_of(diff), tuple(tables), tuple(lists), note)


def _missions(name: str, review: Review, diff: RiskDiff) -> Table:
    old, new = diff.before, diff.after
    kinds: dict[str, str] = {}
    if wording.has_cycles(diff):
        kinds["failure per cycle"] = "cycle_failure_probability"
        kinds["expected cycles"] = "expected_cycles"
    rows = [
        row_of(
            name,
            *(
                _figure_of(mission, figure)
                for mission, figure in zip((old, new), both, strict=True)
            ),
            wording.compared(diff, *both),
        )
        for name, both in wording.mission_figures(diff).items()
    ]
    for label, kind in kinds.items():
        figures = (None if figure is None else getattr(figure, kind) for figure in (old, new))
        ratio = wording.compared(diff, *figures)
        rows.append(row_of(label, _figure(old, kind), _figure(new, kind), ratio))
    columns = (Column("figure"), *numbers(review.before, review.after, "ratio"))
    return Table(f"{name}-mission", "The mission", columns, tuple(rows))


def _changes(name: str, review: Review, diff: RiskDiff) -> Table:
    rows = [
        row_of(
            Cell(change.summary, note=wording.marks(change)),
            wording.alone(change),
            wording.causes(change),
            wording.places(review, change),
            component=change.component,
        )
        for change in diff.changes
    ]
    if diff.interaction is not None and wording.has_interaction(diff):
        text = "what they do only together, and noise"
        rows.append(row_of(text, wording.difference(diff.interaction), "", ""))
    columns = (
        Column("change"),
        Column("alone", "what only it does to mission failure", is_number=True),
        *texts("cause", "where"),
    )
    return Table(f"{name}-changes", "What changed", columns, tuple(rows))


def _functions(name: str, diff: RiskDiff) -> Table:
    rows = tuple(
        row_of(
            Cell(wording.name_of(function), note=wording.status_of(diff, function)),
            *_of_function(function.before),
            *_of_function(function.after),
            function=function.name,
        )
        for function in diff.shown_functions
    )
    columns = (
        Column("function"),
        Column("fails in a visit", "before", is_number=True),
        Column("visits", "before", is_number=True),
        Column("fails in a visit", "after", is_number=True),
        Column("visits", "after", is_number=True),
    )
    return Table(f"{name}-functions", "Functions", columns, rows)


def _figure_of(mission: MissionFigures | None, figure: float | None) -> str:
    if figure is None:
        return _NONE if mission is None else _NOT_KNOWN
    return wording.probability(figure)


def _figure(mission: MissionFigures | None, kind: str) -> str:
    value = None if mission is None else getattr(mission, kind)
    if value is None:
        return _NONE
    return wording.count(value) if kind == "expected_cycles" else wording.probability(value)


def _of_function(function: FunctionFigures | None) -> tuple[str, str]:
    if function is None:
        return _NONE, _NONE
    return wording.probability(function.top_event), wording.count(function.expected_visits)
