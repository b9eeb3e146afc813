"""A page over several controllers: which is how likely to fail, and through what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from tracerisk.common.verdict import Verdict, kind_of
from tracerisk.prm.hybrid.assessment import Assessment
from tracerisk.report.html import figures
from tracerisk.report.html.page import page, rendered
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import Cell, Column, Row, Table, row_of

_ORDER = ("complete", "partial", "faulted", "stuck")


@dataclass(frozen=True, slots=True)
class OverviewRow:
    """One controller, as the page shows it."""

    name: str
    """Path of the controller."""
    verdict: Verdict | None
    """Verdict of the run behind the blocks; `None` where unknown."""
    assessment: Assessment | None
    """Solution of the model; `None` where there is none."""
    error: str = ""
    """Why there is no figure."""
    link: str = ""
    """Where to read on; empty for nowhere."""
    report: str = ""
    """Where its report is; empty where there is none."""


def overview_page(title: str, rows: Sequence[OverviewRow]) -> str:
    """Return one page over the controllers, the same for the same input."""
    return page(f"Risk of {title}", overview_lead(title, rows), [overview_section(rows)])


def overview_lead(title: str, rows: Sequence[OverviewRow]) -> Markup:
    """Return the heading: how many controllers, how their runs came out, which is the riskiest."""
    counts: dict[str, int] = {}
    for row in rows:
        kind = "without a figure" if row.assessment is None else kind_of(row.verdict)
        counts[kind] = counts.get(kind, 0) + 1
    ranked = [overview_row for overview_row in _ranked(rows) if overview_row.assessment is not None]
    first = ranked[0] if ranked else None
    cause = ""
    if first is not None and first.assessment is not None:
        risk = first.assessment.mission.failure_probability
        cause = f"Most likely to fail: {first.name}, {figures.powered(risk)} a mission"
        often = figures.one_in(risk)
        cause += f", {often}." if often else "."
    return rendered(
        "overview.html.j2",
        title=title,
        sentence=figures.counted(len(rows), "controller") + ".",
        counts=[(count, kind) for kind, count in sorted(counts.items(), key=_rank)],
        cause=cause,
        statement=first.assessment.statement if first and first.assessment else "",
    )


def overview_section(rows: Sequence[OverviewRow]) -> Section:
    """Return the table of controllers, the most likely to fail first."""
    has_reports = any(row.report for row in rows)
    most = max((_risk(row) or 0.0 for row in rows), default=0.0)
    columns = (
        Column("controller"),
        Column("verdict", "of its run"),
        Column("mission failure", is_number=True),
        Column("coverage", "functions that ran", is_number=True),
        Column("adds most", "component, and its share"),
        Column("most falls in", "function, and its share"),
        *([Column("report")] if has_reports else []),
    )
    table = Table(
        "controllers",
        "Controllers, the most likely to fail first",
        columns,
        tuple(_row(overview_row, most, has_reports=has_reports) for overview_row in _ranked(rows)),
    )
    return Section("controllers", "Controllers", table.__html__())


def _breakable(path: str) -> Markup:
    """Return a path that goes on below, where it has no room, after an underscore or a slash."""
    text = escape(path)
    for mark in "_/":
        text = text.replace(mark, Markup(f"{mark}<wbr>"))
    return text


def _row(row: OverviewRow, most: float, *, has_reports: bool) -> Row:
    risk = _risk(row)
    coverage = None if row.verdict is None else row.verdict.coverage
    folder, _, file = row.name.rpartition("/")
    notes = (_breakable(folder), row.error)
    report = Cell("report" if row.report else figures.NOTHING, link=row.report)
    return row_of(
        Cell(_breakable(file), link=row.link, note=Markup("; ").join(filter(None, notes))),
        kind_of(row.verdict) if row.assessment is not None else figures.NOTHING,
        figures.NOTHING
        if risk is None
        else Cell(figures.probability(risk), share=risk / most if most else 0.0),
        figures.NOTHING
        if coverage is None or not coverage.all
        else Cell(f"{coverage.ran} of {coverage.all}", share=coverage.ran / coverage.all),
        _component(row.assessment),
        _function(row.assessment),
        *([report] if has_reports else []),
    )


def _ranked(rows: Sequence[OverviewRow]) -> list[OverviewRow]:
    """Return those without a figure first, for nothing is known of them; then by the figure."""

    def rank(row: OverviewRow) -> tuple[float, str]:
        risk = _risk(row)
        return (float("-inf") if risk is None else -risk, row.name)

    return sorted(rows, key=rank)


def _risk(row: OverviewRow) -> float | None:
    return None if row.assessment is None else row.assessment.mission.failure_probability


def _component(assessment: Assessment | None) -> str:
    if assessment is None or not assessment.components:
        return figures.NOTHING
    first = assessment.components[0]
    return f"{first.name}, {figures.percent(first.fussell_vesely)}"


def _function(assessment: Assessment | None) -> str:
    if assessment is None or not assessment.mission.geometric_cycles:
        return figures.NOTHING
    first = max(assessment.states, key=lambda state: state.absorption_probability)
    share = first.absorption_probability / assessment.mission.geometric_cycles
    return f"{first.name}, {figures.percent(share)}"


def _rank(entry: tuple[str, int]) -> tuple[int, str]:
    kind, _ = entry
    return (_ORDER.index(kind) if kind in _ORDER else len(_ORDER), kind)


def report_links(names: Sequence[str], reports: Mapping[str, str]) -> dict[str, str]:
    """Return the report of each controller, of those that are there by the name of their file.

    That of `cell/pick.py` is `cell/pick.html`; `pick.html` is where no other controller has the
    same name.
    """
    links = {}
    stems = [name.rpartition("/")[2].rpartition(".")[0] for name in names]
    for name, stem in zip(names, stems, strict=True):
        wanted = [f"{name.rpartition('.')[0]}.html"]
        if stems.count(stem) == 1:
            wanted.append(f"{stem}.html")
        for key in wanted:
            if key in reports and name not in links:
                links[name] = reports[key]
    return links
