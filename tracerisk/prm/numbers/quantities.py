"""Checks of given figures, which name the figure, its unit and its range."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from tracerisk.errors import ModelError, one_of


def check_share(name: str, value: float) -> None:
    """Raise ModelError when a probability or a share is not in [0, 1]."""
    if not (is_number(value) and 0.0 <= value <= 1.0):
        raise ModelError(f"{name} is {value!r}; allowed: 0 to 1")


def check_not_negative(name: str, value: float, unit: str) -> None:
    """Raise ModelError when a figure is negative, infinite or not a number."""
    if not (is_number(value) and value >= 0.0 and math.isfinite(value)):
        raise ModelError(f"{name} is {value!r}{_in(unit)}; allowed: 0 or more, finite")


def check_positive(name: str, value: float, unit: str) -> None:
    """Raise ModelError when a figure is not above zero, infinite or not a number."""
    if not (is_number(value) and value > 0.0 and math.isfinite(value)):
        raise ModelError(f"{name} is {value!r}{_in(unit)}; allowed: above 0, finite")


def check_count(name: str, value: int, least: int = 0) -> None:
    """Raise ModelError when a figure is not a whole number from `least` on."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ModelError(f"{name} is {value!r}; allowed: whole numbers from {least} on")


def check_mission_time(mission_time_h: float) -> None:
    """Raise ModelError when a mission time is negative, infinite or not a number, [h]."""
    check_not_negative("the mission time", mission_time_h, "h")


def check_parameters(names: Iterable[str], known: Collection[str]) -> None:
    """Raise ModelError when a value is given of what is not a parameter."""
    for name in names:
        if name not in known:
            raise ModelError(f"value of '{name}', which is not a parameter; {one_of(known, name)}")


def is_number(value: object) -> bool:
    """Whether a figure is a number: what a caller gives need not be what its type says."""
    if isinstance(value, int | float):
        return True
    # Imported here: a start-up does without it.
    from numbers import Real

    return isinstance(value, Real)


def _in(unit: str) -> str:
    return f" {unit}" if unit else ""


def check_names(
    kind: str, names: Iterable[str], *, reserved: Collection[str] = (), where: str = ""
) -> None:
    """Raise ModelError when a name cannot be shown, is there twice, or is reserved."""
    seen: set[str] = set()
    for name in names:
        if not name or not name.isprintable():
            raise ModelError(f"{where}{kind} {name!r}: a name needs printable characters")
        if name in seen:
            raise ModelError(f"{where}duplicate {kind} '{name}'; rename one")
        if name in reserved:
            raise ModelError(f"{kind} '{name}': this name is kept for the mission's good end")
        seen.add(name)
