"""What tables are written for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Paper:
    """What tables are written for."""

    width: int = 80
    """The number of columns [characters]."""
    color: bool = False
    """Whether escape sequences of colours are written."""


PAPER = Paper()
