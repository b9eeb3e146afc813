"""What kind of value a YAML file holds, as its errors call it."""

from __future__ import annotations

import math
from typing import Any


def is_finite(value: float) -> bool:
    """Return whether a number is finite and fits a float."""
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number above all floats
        return False


def short(value: float) -> str:
    """Return a number as an error shows it, however many digits it has."""
    text = str(value)
    return text if len(text) < 40 else f"one of {len(text)} digits"


def is_map(value: Any) -> bool:
    """Return whether a value is a mapping that knows its lines."""
    return isinstance(value, dict) and hasattr(value, "lc")


def kind_of(value: Any) -> str:
    """Return what a value is, in words."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return f"the truth value {str(value).lower()}"
    if isinstance(value, int | float):
        return f"the number {short(value)}"
    if isinstance(value, str):
        return f"the string '{value}'"
    if isinstance(value, list):
        return "a list"
    return "a mapping" if isinstance(value, dict) else f"a {type(value).__name__}"
