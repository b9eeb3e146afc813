"""What people set, what the run showed, what it did not, and what is assumed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tracerisk.adder.blocks.override import Override, drift_text
from tracerisk.common.verdict import kind_of
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.report_input import ReportInput
from tracerisk.report.html.section import Section
from tracerisk.report.html.sources import line_links
from tracerisk.report.html.tables import Cell, Column, Table, numbers, row_of, texts

_MOST_NAMED = 2


def pins_section(report: ReportInput) -> Section:
    """Return what users set by hand, why, and how far it is from what is computed."""
    links = line_links(report.sources)
    columns = (
        *texts("field", "set by hand", "computed now"),
        Column("drift", "of the one from the other", is_number=True),
        *texts("reason", "place"),
    )
    rows = tuple(
        row_of(
            pin.field,
            pin.value,
            pin.computed if pin.computed is not None else figures.NOTHING,
            drift(pin),
            Cell(pin.reason or "none given", note="" if pin.reason else "without a reason"),
            Cell(str(pin.location), link=links.get((pin.location.file, pin.location.line), "")),
        )
        for pin in report.pins
    )
    table = Table("pins", "Values set by hand", columns, rows, is_of_cards=True) if rows else None
    return Section("pins", "Set by hand", rendered("pins.html.j2", table=table))


def findings_section(report: ReportInput) -> Section:
    """Return what a user should look at."""
    lines = (*report.findings, *report.assessment.findings)
    is_whole = all(kind_of(verdict) == "complete" for verdict in report.verdicts.values())
    empty = "Nothing stood out." if is_whole else "Nothing but what the verdict names."
    html = rendered("list.html.j2", lines=lines, lead="", empty=empty)
    return Section("findings", "Findings", html)


def coverage_section(report: ReportInput) -> Section:
    """Return the functions that can move the arm and did not run: no risk data, not no risk."""
    trace = report.trace
    table = None
    if trace is not None and trace.uncovered:
        columns = (*texts("function", "file"), *numbers("line"))
        rows = tuple(
            row_of(uncovered.ref.name, uncovered.ref.file, str(uncovered.line))
            for uncovered in trace.uncovered
        )
        table = Table("coverage", "Functions without risk data", columns, rows)
    html = rendered(
        "coverage.html.j2", table=table, is_known=trace is not None, no_trace=report.no_trace
    )
    return Section("coverage", "Coverage", html)


def assumptions_section(report: ReportInput) -> Section:
    """Return what must be believed for the figures to hold."""
    lines = (*report.assumptions, *report.assessment.assumptions)
    lead = "The figures hold if these do."
    html = rendered("list.html.j2", lines=lines, lead=lead, empty="None beyond the model itself.")
    return Section("assumptions", "Assumptions", html)


def by_hand(pins: Sequence[Override]) -> dict[str, list[str]]:
    """Return the functions in which a component's probability is a user's, by component."""
    functions: dict[str, list[str]] = {}
    for pin in pins:
        if pin.figure_of is not None:
            function, component = pin.figure_of
            functions.setdefault(component, []).append(function)
    return functions


def listed(names: Sequence[str]) -> str:
    """Return names in words, of many only how many functions they are."""
    return ", ".join(names) if len(names) <= _MOST_NAMED else f"{len(names)} functions"


def drift(pin: Override) -> str:
    """Return how far a user's value lies from the computed one."""
    if pin.drift is None:
        return figures.NOTHING
    return "computed is zero" if math.isinf(pin.drift) else drift_text(pin.drift)
