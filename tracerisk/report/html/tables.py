"""A table of the report as data; `templates/table.html.j2` writes it."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from tracerisk.report.html import figures
from tracerisk.report.html.page import rendered


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table."""

    heading: str
    """Text of the heading."""
    meaning: str = ""
    """What the heading means, in a few words; "" for nothing."""
    is_number: bool = False
    """Whether the column holds numbers, aligned to the right."""


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell of a table."""

    text: str
    """Text of the cell."""
    link: str = ""
    """Target of a link on the text; "" for none."""
    share: float | None = None
    """Length of a bar in the cell, in [0, 1]; `None` for no bar."""
    function: str | None = None
    """Function that the text as a button chooses; `None` for none."""
    component: str | None = None
    """Component that the text as a button chooses; `None` for none."""
    note: str = ""
    """Text below; "" for none."""
    rows: int = 1
    """Number of rows that the cell spans; 0 where a cell above reaches down here."""


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
    """A row of a table."""

    cells: tuple[Cell, ...]
    """Cells, one for each column; the first is the heading of the row."""
    function: str | None = None
    """Function that the row describes; `None` for none."""
    component: str | None = None
    """Component that the row describes; `None` for none."""


def row_of(*cells: Cell | str, function: str | None = None, component: str | None = None) -> Row:
    """Return a row; a text is a cell that has nothing else."""
    whole = (cell if isinstance(cell, Cell) else Cell(cell) for cell in cells)
    return Row(tuple(whole), function, component)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the page."""

    name: str
    """Id of the table."""
    caption: str
    """Title above the table."""
    columns: tuple[Column, ...]
    """Columns from left to right."""
    rows: tuple[Row, ...]
    """Rows from the top down."""
    is_of_cards: bool = False
    """Whether each row is a card on a narrow screen, with the headings before its cells."""

    def __html__(self) -> Markup:
        """Return the table as HTML."""
        return rendered("table.html.j2", table=self)
