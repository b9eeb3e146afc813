"""A table of the report as data; `templates/table.html.j2` writes it."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered


@dataclass(frozen=True, slots=True)
class Column:
    """A column: its heading, what the heading means in a few words, whether it holds numbers."""

    heading: str
    meaning: str = ""
    is_number: bool = False


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell: its text, a link to follow from it, a share from 0 to 1 drawn as a bar.

    With a `function` or a `component` the text is a button that chooses it.
    `note` stands below the text. The cell spans `rows`, none where one above reaches down here.
    """

    text: str
    link: str = ""
    share: float | None = None
    function: str | None = None
    component: str | None = None
    note: str = ""
    rows: int = 1


def texts(*headings: str) -> tuple[Column, ...]:
    """Return columns of texts."""
    return tuple(map(Column, headings))


def numbers(*headings: str) -> tuple[Column, ...]:
    """Return columns of numbers."""
    return tuple(Column(heading, is_number=True) for heading in headings)


def share_cell(share: float) -> Cell:
    """Return a cell with a share and its bar."""
    return Cell(figures.percent(share), share=min(max(share, 0.0), 1.0))


@dataclass(frozen=True, slots=True)
class Row:
    """A row, and the function or component that it describes."""

    cells: tuple[Cell, ...]
    function: str | None = None
    component: str | None = None


def row_of(*cells: Cell | str, function: str | None = None, component: str | None = None) -> Row:
    """Return a row; a text is a cell that has nothing else."""
    whole = (each if isinstance(each, Cell) else Cell(each) for each in cells)
    return Row(tuple(whole), function, component)


@dataclass(frozen=True, slots=True)
class Table:
    """A table with its id, caption, columns and rows; the first cell of a row is its heading."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]

    def __html__(self) -> Markup:
        """Return the table as HTML."""
        return rendered("table.html.j2", table=self)
