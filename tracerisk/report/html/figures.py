"""How numbers are written in the report."""

from __future__ import annotations

import math

from tracerisk.common.text.one_in import one_in as one_in

NOTHING = "\N{EN DASH}"
"""What stands in a cell for which there is no figure."""

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def probability(value: float) -> str:
    """Return a probability as the tables and blocks have it."""
    return f"{value:.3e}" if 0.0 < value < 1e-3 else f"{value:.4g}"


def powered(value: float, digits: int = 3) -> str:
    """Return a number for a sentence, 1.26 x 10⁻⁶, which no line end parts."""
    if value == 0.0 or 1e-3 <= value < 1e4:
        return f"{value:.{digits}g}"
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    power = str(int(exponent)).translate(_SUPERSCRIPTS)
    return f"{mantissa}\N{NO-BREAK SPACE}\N{MULTIPLICATION SIGN}\N{NO-BREAK SPACE}10{power}"


def percent(share: float) -> str:
    """Return a share in percent, to three digits; never as 0 % or 100 % where it is neither."""
    if 0.0 < share < 1e-4:
        return "<\N{NO-BREAK SPACE}0.01\N{NO-BREAK SPACE}%"
    if 0.9995 <= share < 1.0 - 1e-9:
        return ">\N{NO-BREAK SPACE}99.9\N{NO-BREAK SPACE}%"
    return f"{100.0 * share:.3g}\N{NO-BREAK SPACE}%"


def ratio(value: float) -> str:
    """Return how many times one figure is another."""
    if math.isinf(value):
        return "∞"
    return f"{value:.3e}" if value >= 1e5 else f"{value:.4g}"


def count(value: float) -> str:
    """Return a number of visits or cycles."""
    return f"{value:.4g}"


def seconds(value: float | None) -> str:
    """Return a time; a dash where none is known."""
    return NOTHING if value is None else f"{value:.2f}"


def counted(number: int, thing: str) -> str:
    """Return a number of things in words."""
    return f"{number:,} {thing}" if number == 1 else f"{number:,} {thing}s"
