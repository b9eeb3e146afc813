"""How the figure of a controller went over the commits: a chart, and the commits as a table."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from tracerisk.common.verdict import kind_of
from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered
from tracerisk.report.html.section import Section
from tracerisk.report.html.tables import Cell, Column, Row, Table, numbers, row_of, texts
from tracerisk.report.series.history import HistoryPoint, changes_of, history_svg

MOST_SHOWN = 20
"""How many commits are in sight; those before them are folded."""
_ALL = "Commits that changed the risk, the oldest first"
_LATEST = "The latest commits that changed the risk, the oldest first"
_EARLIER = "Earlier commits that changed the risk, the oldest first"


def history_section(name: str, rows: Sequence[HistoryPoint]) -> Section:
    """Return the section of a history, the oldest commit first in chart and table."""
    table_rows = _rows(rows)
    earlier = table_rows[:-MOST_SHOWN] if len(table_rows) > MOST_SHOWN + 1 else []
    html = rendered(
        "history.html.j2",
        name=name,
        chart=Markup(history_svg({name: rows})),
        table=_table("history", _LATEST if earlier else _ALL, table_rows[len(earlier) :])
        if rows
        else None,
        earlier=_table("history-earlier", _EARLIER, earlier) if earlier else None,
    )
    return Section("history", "History", html)


def _rows(rows: Sequence[HistoryPoint]) -> list[Row]:
    result = []
    for row, change in zip(rows, changes_of(rows), strict=True):
        risk = row.failure_probability
        none = "unreadable" if row.error else figures.NOTHING
        result.append(
            row_of(
                Cell(row.name, note=row.date),
                none if risk is None else figures.probability(risk),
                change,
                kind_of(row.verdict),
                Cell(row.subject, note=row.change),
            )
        )
    return result


def _table(name: str, caption: str, rows: Sequence[Row]) -> Table:
    columns = (
        *texts("commit"),
        *numbers("mission failure", "ratio"),
        *texts("verdict"),
        Column("subject", "and what it did to the risk"),
    )
    return Table(name, caption, columns, tuple(rows))
