"""What tables are written for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Paper:
    """What tables are written for: its columns, and whether it takes escapes of colours."""

    width: int = 80
    color: bool = False


PAPER = Paper()
