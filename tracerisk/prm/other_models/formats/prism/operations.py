"""The signs and functions of the PRISM language, and what they compute."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping

Value = bool | int | float

_MOST_BITS = 2048  # of a whole number: more than any double has
_LARGEST = 1 << _MOST_BITS


def _power(base: Value, exponent: Value) -> Value:
    is_whole = isinstance(base, int) and isinstance(exponent, int) and exponent > 0
    if is_whole and int(base).bit_length() * exponent > _MOST_BITS:
        raise OverflowError("a power that is too large")
    result = pow(base, exponent)
    if isinstance(result, complex):
        raise ValueError("a power that is no real number")
    return result


def _times(left: Value, right: Value) -> Value:
    result = left * right
    if isinstance(result, int) and not -_LARGEST < result < _LARGEST:
        raise OverflowError("a product that is too large")
    return result


SIGNS: Mapping[str, tuple[int, Callable[[Value, Value], Value] | None]] = {
    "=>": (1, None),
    "<=>": (1, None),
    "|": (2, None),
    "&": (3, None),
    "=": (5, operator.eq),
    "!=": (5, operator.ne),
    "<": (6, operator.lt),
    "<=": (6, operator.le),
    ">": (6, operator.gt),
    ">=": (6, operator.ge),
    "+": (7, operator.add),
    "-": (7, operator.sub),
    "*": (8, _times),
    "/": (8, operator.truediv),
}
"""How tightly each sign between two inputs binds, and its value where both inputs are needed."""
FUNCTIONS: Mapping[str, tuple[int | None, Callable[..., Value]]] = {
    "min": (None, min),
    "max": (None, max),
    "floor": (1, math.floor),
    "ceil": (1, math.ceil),
    "round": (1, lambda x: math.floor(x + 0.5)),
    "pow": (2, _power),
    "mod": (2, operator.mod),
    "log": (2, lambda x, base: math.log(x) / math.log(base)),
}
"""How many arguments each function takes, any number from one on for `None`, and its value."""
