"""Tables for a terminal, the same for the same input on every machine."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table


def rendered(write: Callable[[Console], None], *, width: int = 80, color: bool = False) -> str:
    """Return as text what `write` prints to a console.

    `width` is the number of columns, at least 60; `color` adds escape sequences.
    """
    from rich.console import Console

    stream = io.StringIO()
    console = Console(
        file=stream,
        width=max(width, 60),
        force_terminal=color,
        color_system="standard" if color else None,
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


def render_parts(parts: Sequence[RenderableType], *, width: int = 80, color: bool = False) -> str:
    """Return tables and lines as text, one below the other; see `rendered`."""

    def write(console: Console) -> None:
        for part in parts:
            console.print(part)

    return rendered(write, width=width, color=color)


def table_of(title: str) -> Table:
    """Return an empty table."""
    from rich import box
    from rich.table import Table

    return Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1),
        collapse_padding=True,
        caption=" ",
    )


def plain(cells: Sequence[str]) -> list[RenderableType]:
    """Keep names with brackets from being read as markup."""
    from rich.text import Text

    return [Text(cell) for cell in cells]


def counted(number: float, thing: str) -> str:
    """Return a number of things, in words."""
    text = f"{number:.4g}"
    return f"{text} {thing}" if text == "1" else f"{text} {thing}s"
