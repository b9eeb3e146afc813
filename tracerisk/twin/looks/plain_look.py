"""The look of a link for which none is made: its shapes, and a housing at each joint."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tracerisk.common.geometry.rotation import quaternion_of, rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.looks.look import Piece, Point

HOUSING = "#8d949e"
"""Paint of housings."""


def piece_of(shape: Shape) -> Piece:
    """Return a shape as a piece."""
    if shape.kind == "box":
        return Piece(box=shape.size, xyz=shape.xyz, rpy=shape.rpy)
    radius, half = (*shape.size, 0.0)[:2]
    if shape.kind == "sphere":
        return Piece(tube=(*shape.xyz, radius))
    ends = [_moved(shape, (0.0, 0.0, side * half)) for side in (-1.0, 1.0)]
    tube = tuple(value for end in ends for value in (*end, radius))
    return Piece(tube=tube, is_flat=shape.kind == "cylinder")


def housing(axis: Point, around: Sequence[Shape], along: bool) -> Piece | None:
    """Return the housing of a drive at the origin, turning about `axis`; `None` where nothing is.

    `around` are the shapes that it holds. Where one goes along the axis it is a belt about it,
    else a drum across.
    """
    if not around:
        return None
    radius = max(min(shape.size) if shape.kind == "box" else shape.size[0] for shape in around)
    wide, half = (radius * 1.12, radius * 0.34) if along else (radius * 0.75, radius * 1.15)
    length = math.hypot(*axis)
    end = [value / length * half for value in axis]
    tube = (-end[0], -end[1], -end[2], wide, end[0], end[1], end[2], wide)
    return Piece(tube=tube, is_flat=True, paint=HOUSING, is_joint=True)


def _moved(shape: Shape, point: Point) -> Point:
    x, y, z = rotated(quaternion_of(shape.rpy), point)
    return x + shape.xyz[0], y + shape.xyz[1], z + shape.xyz[2]
