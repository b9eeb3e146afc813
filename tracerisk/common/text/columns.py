"""How wide a terminal is, known without what `shutil` imports."""

from __future__ import annotations

import os

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TextIO


def columns_of(stream: TextIO | None) -> int:
    """Return the columns of a stream's terminal: those of `COLUMNS`, 80 where none are known."""
    try:
        given = int(os.environ["COLUMNS"])
    except (KeyError, ValueError):
        given = 0
    if given > 0:
        return given
    try:
        return os.get_terminal_size(stream.fileno()).columns or 80  # type: ignore[union-attr]
    except (AttributeError, ValueError, OSError):  # no terminal, or no stream
        return 80
