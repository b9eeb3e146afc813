"""The names of functions and the shares that stand beside them, as regular expressions."""

from __future__ import annotations

from fractions import Fraction

TARGET = r"[^\s!{},;/]+(?: \([^\s!{}(),;:=/]+(?: [^\s!{}(),;:=/]+)*\))?"
WEIGHT = r"(?:[0-9]+/[0-9]+|[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"


def read_share(text: str) -> Fraction | None:
    """Return the share that a text matched by `WEIGHT` states; `None` unless above 0, up to 1."""
    try:
        share = Fraction(text)
    except ZeroDivisionError:
        return None
    return share if 0 < share <= 1 else None
