"""Where a drafted pose is moved to, so that what a controller makes of it is reached."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

Vector = tuple[float, float, float]
PlaceAndShift = tuple[Vector, Vector]
"""A place that was not reached and by how much to move it, in the frame of the base [m]."""

# Not more: to find that a pose is not reached takes a tenth of a second.
_NEARER = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5)  # of the way from the base
_HIGHER = (0.0, -0.05, -0.1, -0.15, -0.2, 0.1)  # [m]
_NEAR = 0.5  # what is farther away was made of another pose [m]
_NO_PLACES = frozenset({"linear", "angular", "rotation", "rpy", "axis", "force", "torque", "scale"})


def reachable_shift(place: Vector, is_reached: Callable[[Vector], bool]) -> Vector | None:
    """Return by how much to move a `place` in the frame of the base, the least that helps [m].

    `is_reached` says whether all that is to be reached would be, moved by so much; None: nothing
    that is tried helps.
    """
    x, y, z = place
    rows = [
        ((nearer - 1) * x, (nearer - 1) * y, higher)
        for nearer, higher in itertools.product(_NEARER, _HIGHER)
        if (nearer, higher) != (1.0, 0.0) and z + higher > 0
    ]
    rows.sort(key=lambda row: math.hypot(*row))
    return next((row for row in rows if is_reached(row)), None)


def shifted(value: Any, place: Sequence[float], by: Sequence[float], name: str = "") -> Any:
    """Return the value of an entry with the positions in it that are near a `place` moved.

    What is held by a link moves with it, and turns and speeds are no positions.
    """
    if isinstance(value, Mapping):
        if "attached" in value or name in _NO_PLACES:
            return value
        if {"x", "y", "z"} <= value.keys() and "w" not in value:
            at = tuple(value[key] for key in "xyz")
            return {**value, **dict(zip("xyz", _moved(at, place, by), strict=True))}
        return {key: shifted(item, place, by, key) for key, item in value.items()}
    if isinstance(value, list):
        if name == "xyz":
            return list(_moved(value, place, by))
        return [shifted(item, place, by, name) for item in value]
    return value


def _moved(at: Sequence[float], place: Sequence[float], by: Sequence[float]) -> Sequence[float]:
    # What stands in the origin is the base itself.
    if math.dist(at[:2], place[:2]) > _NEAR or not any(at):
        return at
    return [round(a + b, 3) + 0.0 for a, b in zip(at, by, strict=True)]
