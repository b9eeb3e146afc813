"""Which function leans on which component, for how long, and what that does to the mission."""

from __future__ import annotations

from tracerisk.prm.hybrid.assessment import StateAssessment
from tracerisk.report.functions_table import units_needed
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.sources import definitions
from tracerisk.report.html.tables import (
    Cell,
    Column,
    Row,
    Table,
    numbers,
    row_of,
    share_cell,
    texts,
)

MOST_COLUMNS = 12
"""How many components the table of shares has; those that matter most."""


def functions_section(report: ReportInput) -> Section:
    """Return the table of functions and that of each component's share in each."""
    html = rendered(
        "functions.html.j2",
        table=_functions(report),
        shares=_shares(report),
        has_times=report.exposures is not None,
    )
    return Section("functions", "Functions", html)


def _functions(report: ReportInput) -> Table:
    has_times = report.exposures is not None
    columns = [
        *texts("function", "component", "units needed"),
        *([Column("active", "seconds of the run", is_number=True)] if has_times else []),
        Column("one unit", "fails in a visit", is_number=True),
        Column("fails in a visit", is_number=True),
        Column("visits", "of a mission", is_number=True),
        Column("ends the mission", is_number=True),
    ]
    places = definitions(report.sources)
    rows = [
        row for state in report.assessment.states for row in _of_function(report, state, places)
    ]
    return Table(
        "functions", "Functions and the components they lean on", tuple(columns), tuple(rows)
    )


def _of_function(
    report: ReportInput, state: StateAssessment, places: dict[str, tuple[str, int]]
) -> list[Row]:
    exposures = report.exposures
    link, line = places.get(state.name, ("", None))
    note = f"step {state.call_sequence}{'' if line is None else f', line {line}'}"
    count = max(len(state.components), 1)
    rows = []
    for index, component in enumerate(state.components or (None,)):
        span = count if index == 0 else 0
        named = None if component is None else component.component
        cells: list[Cell | str] = ["none", figures.NOTHING]
        fails = figures.NOTHING
        if component is not None:
            fails = figures.probability(component.probability)
            cells = [Cell(component.name, component=named), units_needed(component)]
        if exposures is not None:
            active = exposures.get(state.name, {})
            cells.append(figures.seconds(None if named is None else active.get(named)))
        rows.append(
            row_of(
                Cell(state.name, link=link, function=state.name, note=note, rows=span),
                *cells,
                fails,
                Cell(figures.probability(state.top_event), rows=span),
                Cell(figures.count(state.expected_visits), rows=span),
                Cell(figures.probability(state.absorption_probability), rows=span),
                function=state.name,
                component=named,
            )
        )
    return rows


def _shares(report: ReportInput) -> Table | None:
    """Return the criticality of each component in each function; `None` for nothing to share."""
    components = report.assessment.components[:MOST_COLUMNS]
    if not components or not report.assessment.mission.failure_probability:
        return None
    shares = {
        (part.name, component.name): part.criticality
        for component in components
        for part in component.by_state
    }
    rows = []
    for state in report.assessment.states:
        values = [shares.get((state.name, component.name)) for component in components]
        cells = [figures.NOTHING if share is None else share_cell(share) for share in values]
        name = Cell(state.name, function=state.name)
        rows.append(row_of(name, *cells, function=state.name))
    columns = (Column("function"), *numbers(*(component.name for component in components)))
    return Table(
        "shares",
        "Share of each component, in each function, in the mission's failure",
        columns,
        tuple(rows),
    )
