"""Results as tables: rows by their names, columns as arrays, text and HTML."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.arrays import np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MOST_SHOWN = 60


class Named(Protocol):
    """A frozen dataclass with a name, whose other fields are the columns."""

    @property
    def name(self) -> str:
        """The row's name."""
        ...


Row = TypeVar("Row", bound=Named)


@dataclass(frozen=True, slots=True)
class Table(Generic[Row]):
    """Rows of one kind, in an order that says something."""

    rows: tuple[Row, ...]
    """Records of one type with unique names; their numeric fields are the columns."""

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __getitem__(self, name: str) -> Row:
        """Return the row of a name.

        Raises ModelError when there is none.
        """
        for row in self.rows:
            if row.name == name:
                return row
        raise ModelError(f"'{name}' is not a row; {one_of((row.name for row in self.rows), name)}")

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the rows."""
        return tuple(row.name for row in self.rows)

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns that hold numbers."""
        if not self.rows:
            return ()
        row: Any = self.rows[0]
        return tuple(
            field.name for field in fields(row) if isinstance(getattr(row, field.name), int | float)
        )

    def column(self, name: str) -> NDArray[np.float64]:
        """Return a column in the order of the rows, (n,).

        Raises ModelError when there is none of that name.
        """
        if self.rows and name not in self.columns:
            raise ModelError(f"'{name}' is not a column; {one_of(self.columns, name)}")
        return np.array([getattr(row, name) for row in self.rows], dtype=np.float64)

    def to_dict(self) -> dict[str, list[Any]]:
        """Return the columns as lists, the names first: what a data frame is made of."""
        columns: dict[str, list[Any]] = {"name": list(self.names)}
        for name in self.columns:
            columns[name] = [getattr(row, name) for row in self.rows]
        return columns

    def __str__(self) -> str:
        lines = _texts(self)
        more = [f"and {len(self) - _MOST_SHOWN} more"] if len(self) > _MOST_SHOWN else []
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        shown = [
            "  ".join(
                text.ljust(width) if rank == 0 else text.rjust(width)
                for rank, (text, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        ]
        return "\n".join(shown + more)

    def _repr_html_(self) -> str:
        head, *body = _texts(self)
        more = f"<p>and {len(self) - _MOST_SHOWN} more</p>" if len(self) > _MOST_SHOWN else ""
        return (
            f"<table><thead>{_html_row('th', head)}</thead>"
            f"<tbody>{''.join(_html_row('td', line) for line in body)}</tbody></table>{more}"
        )

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        # The text that stands beside the HTML in a notebook.
        return {"text/plain": str(self)}


def _texts(table: Table[Any]) -> list[list[str]]:
    head = ["name", *(name.replace("_", " ") for name in table.columns)]
    return [head] + [
        [row.name, *(f"{getattr(row, name):.6g}" for name in table.columns)]
        for row in table.rows[:_MOST_SHOWN]
    ]


def _html_row(tag: str, texts: list[str]) -> str:
    from html import escape

    return f"<tr>{''.join(f'<{tag}>{escape(text)}</{tag}>' for text in texts)}</tr>"
