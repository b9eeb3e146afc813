"""Read numbers and JSON that others wrote, within bounds of size and depth.

What is past a bound is a `ValueError` like any other malformed text, so that a reader needs one
kind of refusal: Python itself raises OverflowError, RecursionError, or reads `1e999` as infinite.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

MOST_DIGITS = 400
"""The digits of the longest number that is read; the largest double has 309."""

Pairs = list[tuple[str, Any]]


def whole_number(text: str) -> int:
    """Return the whole number that `text` states; raise ValueError if it is none, or too long."""
    _check_length(text)
    return int(text)


def finite_number(text: str) -> float:
    """Return the number that `text` states; raise ValueError if it is none, or not finite."""
    _check_length(text)
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"a number is not finite: {text[:20]}")
    return value


def _check_length(text: str) -> None:
    if len(text) > MOST_DIGITS:
        raise ValueError(f"a number of {len(text)} digits; at most {MOST_DIGITS} are allowed")


def loads_json(
    text: str | bytes, *, object_pairs_hook: Callable[[Pairs], Any] | None = None
) -> Any:
    """Return what a JSON text states.

    Raises ValueError (JSONDecodeError, with the place, where the text is not JSON) for numbers that
    are too long or not finite, and for a text that nests too deeply.
    """
    try:
        return json.loads(
            text,
            parse_int=whole_number,
            parse_float=finite_number,
            parse_constant=finite_number,
            object_pairs_hook=object_pairs_hook,
        )
    except RecursionError as error:
        raise ValueError("it nests too deeply") from error
