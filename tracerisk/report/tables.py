"""Tables for a terminal, the same for the same input on every machine."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from tracerisk.common.text.paper import PAPER, Paper
from tracerisk.common.text.printable import without_controls

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rich.console import Console, OverflowMethod, RenderableType
    from rich.table import Table

LEAST_WIDTH = 60
ROOMY = 72
"""Columns below which what matters less is left out, so that names have room."""

WIDE = 110
"""Columns from which there is room for bars, and for tables side by side."""

MOST_WIDTH = 160
"""Columns beyond which lines would only become harder to follow."""

MEASURES = {
    "birnbaum": "Birnbaum",
    "criticality": "criticality",
    "fussell_vesely": "Fussell-V.",
    "risk_reduction_worth": "RRW",
    "risk_achievement_worth": "RAW",
    "tenfold": "tenfold",
}
"""The headings of importance measures."""
_BAR_WIDTH = 12
_GAP = "  "

_UNIT = re.compile(r"(?<=\d) (?=(?:%|s|m|mm|N|Nm)(?![\w/]))")


def rendered(write: Callable[[Console], None], paper: Paper = PAPER) -> str:
    """Return as text what `write` prints to a console.

    The number of columns is taken as at least 60 and at most 160.
    """
    from rich.console import Console

    stream = io.StringIO()
    console = Console(
        file=stream,
        width=min(max(paper.width, LEAST_WIDTH), MOST_WIDTH),
        force_terminal=paper.color,
        color_system="standard" if paper.color else None,
        highlight=False,
        emoji=False,
        markup=False,
        legacy_windows=False,
        safe_box=False,
        _environ={},
    )
    write(console)
    lines = (line.rstrip() for line in stream.getvalue().splitlines())
    return "\n".join(lines) + "\n"


def render_parts(parts: Sequence[RenderableType], paper: Paper = PAPER) -> str:
    """Return tables and lines as text, one below the other; see `rendered`."""

    def write(console: Console) -> None:
        for part in parts:
            console.print(part)

    return rendered(write, paper)


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table of text."""

    heading: str
    """Text of the heading."""
    is_number: bool = False
    """To the right, and never broken; else a cell that is too long goes on below."""


def render_table(
    title: str,
    columns: Sequence[Column],
    rows: Sequence[Sequence[str]],
    paper: Paper = PAPER,
) -> str:
    """Return a line of text and a table below it; `width` and `color` as of `rendered`.

    What fits as it is needs no library, which takes longer to load than a small model to solve.
    """
    if not paper.color:
        text = _plain_table(title, columns, rows, min(max(paper.width, LEAST_WIDTH), MOST_WIDTH))
        if text is not None:
            return text
    table = table_of("")
    for column in columns:
        if column.is_number:
            table.add_column(column.heading, justify="right", no_wrap=True)
        else:
            table.add_column(column.heading, overflow="fold")
    for row in rows:
        table.add_row(*plain(row))
    return render_parts([*plain([title]), table], paper)


def _plain_table(
    title: str, columns: Sequence[Column], rows: Sequence[Sequence[str]], width: int
) -> str | None:
    """Return the text of a table; `None` where it is too wide, or signs differ in width."""
    headings = [column.heading for column in columns]
    cells = [title, *headings, *(cell for row in rows for cell in row)]
    if not all(cell.isascii() and cell.isprintable() and cell == cell.strip() for cell in cells):
        return None
    widths = [max(map(len, item)) for item in zip(headings, *rows, strict=True)]
    total = sum(widths) + len(_GAP) * (len(widths) - 1)
    if max(total, len(title)) > width or not title or not all(widths):
        return None
    lines = [title, "", "\N{BOX DRAWINGS LIGHT HORIZONTAL}" * total]
    for row in (headings, *rows):
        parts = (
            cell.rjust(room) if column.is_number else cell.ljust(room)
            for cell, room, column in zip(row, widths, columns, strict=True)
        )
        lines.append(_GAP.join(parts).rstrip())
    lines[1] = lines.pop(3)
    return "\n".join([*lines, "", ""])


def csv_of(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table as CSV."""
    import csv

    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(headings)
    writer.writerows(rows)
    return stream.getvalue()


def table_of(
    title: str,
    texts: Iterable[str] = (),
    numbers: Iterable[str] = (),
    rows: Iterable[Sequence[str]] = (),
    *,
    style: str = "bold",
    overflow: OverflowMethod | None = None,
) -> Table:
    """Return a table with columns of texts, then of numbers, and rows of both.

    A number is never broken; one that has too little room goes on by `overflow`, if any is given.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=Text(without_controls(title), style=style, overflow="fold"),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1),
        collapse_padding=True,
        caption=" ",
    )
    for heading in texts:
        table.add_column(heading, overflow="fold")
    for heading in numbers:
        if overflow is None:
            table.add_column(heading, justify="right", no_wrap=True)
        else:
            table.add_column(heading, justify="right", overflow=overflow)
    for row in rows:
        table.add_row(*plain(row))
    return table


def part_of(title: str, shown: int, count: int) -> str:
    """Return the title of a table that shows so many of all, which it says where it is a part."""
    return f"{title} ({shown} of {count})" if count > shown else title


def plain(cells: Sequence[str]) -> list[RenderableType]:
    """Keep names from being read as markup, and controls in them from reaching the terminal."""
    from rich.text import Text

    return [Text(without_controls(cell)) for cell in cells]


def add_share_columns(table: Table, width: int, *, heading: str = "share") -> None:
    """Add the columns of `share_cells`."""
    table.add_column(heading, justify="right", no_wrap=True)
    if width >= WIDE:
        table.add_column("", width=_BAR_WIDTH)


def share_cells(share: float, width: int) -> list[RenderableType]:
    """Return a share of the risk: its figure, and its bar where there is room for one.

    The colour says what the figure says: half or more, a tenth or more, less than a hundredth.
    """
    from rich.bar import Bar
    from rich.text import Text

    style, color = _weight(share)
    cells: list[RenderableType] = [Text(share_text(share), style=style)]
    if width >= WIDE:
        cells.append(Bar(1.0, 0.0, share, width=_BAR_WIDTH, color=color))
    return cells


def filled(text: str, width: int, margin: str = "", *, breaks_words: bool = False) -> str:
    """Return text broken between words, but never between a number and its unit.

    A word that is wider than a line is broken only if asked.
    """
    import textwrap

    joined = _UNIT.sub("\N{NO-BREAK SPACE}", without_controls(text))
    lines = textwrap.fill(
        joined,
        width,
        subsequent_indent=margin,
        break_long_words=breaks_words,
        break_on_hyphens=False,
        replace_whitespace=False,
    )
    return lines.replace("\N{NO-BREAK SPACE}", " ")


def share_text(share: float) -> str:
    """Return a share in percent; below 0.01 % no digits, which would only seem to matter."""
    return "<0.01 %" if 0.0 < share < 1e-4 else f"{100.0 * share:.3g} %"


def _weight(share: float) -> tuple[str, str]:
    """Return the style of a figure and the colour of its bar."""
    if share >= 0.5:
        return "bold red", "red"
    if share >= 0.1:
        return "yellow", "yellow"
    return ("", "default") if share >= 0.01 else ("dim", "default")


def counted(number: float, thing: str) -> str:
    """Return a number of things, in words."""
    text = f"{number:.4g}"
    return f"{text} {thing}" if text == "1" else f"{text} {thing}s"
