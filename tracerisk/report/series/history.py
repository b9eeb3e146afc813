"""How a risk went over the commits: a table, a chart, a badge."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.common.verdict import Verdict, kind_of
from tracerisk.prm.review.risk_diff import WORKING_TREE
from tracerisk.report.diff.sentences import sentence
from tracerisk.report.diff.wording import compared
from tracerisk.report.series.sweep import SweepPoint, plot_svg
from tracerisk.report.tables import LEAST_WIDTH, MOST_WIDTH, render_parts, table_of

if TYPE_CHECKING:
    from rich.console import JustifyMethod

    from tracerisk.prm.review.risk_diff import RiskDiff

_COLOURS: Mapping[str, str] = {
    "complete": "#2c7a3f",
    "partial": "#8a6d00",
    "faulted": "#b3261e",
    "stuck": "#b3261e",
}
_LEAST_SUBJECT = 20
"""Columns below which the date is left out, so that the subject has room."""
_GREY = "#5f6368"
_CHARACTER = 6.6
"""The width of a character of the badge's font at 11 px [px]."""


@dataclass(frozen=True, slots=True)
class HistoryPoint:
    """A controller after one commit that changed it."""

    commit: str
    """The hash; empty for the working tree."""
    date: str
    """Of the commit, as 2026-11-23; empty for the working tree."""
    subject: str
    """First line of the commit message; empty for the working tree."""
    path: str
    """Where its script is, from the top of the repository."""
    failure_probability: float | None
    """Of a mission by hardware; `None` where it has no blocks, or none that can be read."""
    verdict: Verdict | None
    """Of the run behind the blocks; `None` where it is unknown."""
    diff: RiskDiff | None = None
    """What the commit did to the risk; `None` where nothing of it changed."""
    error: str = ""
    """Why its blocks cannot be read, in words."""

    @property
    def is_news(self) -> bool:
        """Whether it says something: another risk, another verdict, or that it cannot be read."""
        if self.diff is None:
            return bool(self.error)
        verdicts = self.diff.verdicts
        is_judged = verdicts is not None and (
            kind_of(verdicts.before) != kind_of(verdicts.after)
            or bool(verdicts.broke or verdicts.repaired or verdicts.new_acceptances)
        )
        outcome = self.diff.outcome
        is_other = outcome is not None and bool(outcome.of_mission)
        return not self.diff.is_unchanged or is_judged or is_other

    @property
    def figure_before(self) -> float | None:
        """The figure of the commit that it is compared with; `None` where that had none."""
        before = None if self.diff is None else self.diff.before
        return None if before is None else before.failure_probability

    @property
    def outcome_mark(self) -> str:
        """What the commit did to what the mission brings about: `result`, `way` or nothing."""
        outcome = None if self.diff is None else self.diff.outcome
        if outcome is None or not outcome.of_mission:
            return ""
        return "result" if outcome.result else "way"

    @property
    def is_comparable(self) -> bool:
        """Whether its figure may be held against the one before, as `diff` holds them."""
        return self.diff is None or self.diff.is_comparable

    @property
    def change(self) -> str:
        """What the commit did to the risk, in words."""
        return self.error if self.diff is None else sentence(self.diff)

    @property
    def name(self) -> str:
        """What a table calls it."""
        return self.commit[:8] or WORKING_TREE


def changes_of(rows: Sequence[HistoryPoint]) -> Iterator[str]:
    """Yield for each commit its figure over that of its parent, or why there is no ratio."""
    for row in rows:
        yield (
            compared(row.diff, row.figure_before, row.failure_probability)
            if row.diff is not None
            else ""
        )


def render_history(name: str, rows: Sequence[HistoryPoint], paper: Paper = PAPER) -> str:
    """Return the table of one controller for a terminal, the oldest commit first."""
    marked = [row.outcome_mark for row in rows]
    columns = {
        "commit": [row.name for row in rows],
        "date": [row.date for row in rows],
        "failure": [_figure(row) for row in rows],
        "ratio": list(changes_of(rows)),
        "changes": marked,
        "verdict": [kind_of(row.verdict) for row in rows],
    }
    if not any(marked):
        del columns["changes"]
    room = _room(columns, paper)
    if room < _LEAST_SUBJECT:
        del columns["date"]
        room = _room(columns, paper)
    table = table_of(name)
    for heading in (*columns, "subject"):
        justify: JustifyMethod = "right" if heading in ("failure", "ratio") else "left"
        table.add_column(heading, justify=justify, overflow="fold")
    for row, *cells in zip(rows, *columns.values(), strict=True):
        table.add_row(*cells, _cut(row.subject, room))
    return render_parts([table], paper)


def _figure(row: HistoryPoint) -> str:
    figure = row.failure_probability
    return "unreadable" if row.error else "-" if figure is None else f"{figure:.3e}"


def _room(columns: Mapping[str, Sequence[str]], paper: Paper) -> int:
    """Return how many columns the subject has beside the others, each with its gap."""
    taken = sum(max(map(len, (name, *cells))) + 2 for name, cells in columns.items())
    return min(max(paper.width, LEAST_WIDTH), MOST_WIDTH) - taken


def _cut(subject: str, room: int) -> str:
    """Return a subject of one line, so that a commit is one."""
    most = max(room, _LEAST_SUBJECT)
    return subject if len(subject) <= most else f"{subject[: most - 3].rstrip()}..."


def history_svg(histories: Mapping[str, Sequence[HistoryPoint]]) -> str:
    """Return a chart: the figure after each commit, a line for each controller."""
    is_one = len(histories) == 1
    return plot_svg(
        [
            SweepPoint(
                {"commit": row.name} if is_one else {"commit": row.name, "controller": name},
                row.failure_probability,
                kind_of(row.verdict),
            )
            for name, rows in histories.items()
            for row in rows
        ]
    )


def badge_svg(
    figure: float | None, verdict: Verdict | None, undetected: float | None = None
) -> str:
    """Return a badge: the verdict and the figures of a mission."""
    left = "mission failure"
    right = "no risk blocks" if figure is None else f"{figure:.2e}"
    kind = kind_of(verdict)
    if undetected is not None:
        right += f", undetected {undetected:.2e}"
    if figure is not None:
        right += f", {kind.removeprefix('verdict ')}"
    colour = _COLOURS.get(kind, _GREY) if figure is not None else _GREY
    first, second = (round(_CHARACTER * len(text) + 14.0) for text in (left, right))
    whole = first + second
    style = "font:11px Verdana,DejaVu Sans,sans-serif"
    title = escape(f"{left}: {right}")
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{whole}" height="20" role="img">'
        f"<title>{title}</title>"
        f'<rect width="{whole}" height="20" rx="3" fill="#3c4043"/>'
        f'<path d="M{first} 0h{second - 3}a3 3 0 0 1 3 3v14a3 3 0 0 1 -3 3h-{second - 3}z" '
        f'fill="{colour}"/>'
        f'<g fill="#fff" text-anchor="middle" style="{style}">'
        f'<text x="{first / 2:g}" y="14">{escape(left)}</text>'
        f'<text x="{first + second / 2:g}" y="14">{escape(right)}</text></g></svg>\n'
    )
