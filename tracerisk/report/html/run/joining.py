"""Rods that join the bodies of an arm where their shapes leave a gap.

A robot without meshes is shown by what stands for them, which need not reach to its joints: a hand
would hover apart from its wrist. The rods are drawn, and not simulated.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from tracerisk.common.geometry.rotation import quaternion_of, rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.report.html.run.replay_model import Body

Point = tuple[float, float, float]

GAP_M = 0.01
"""A gap below this is not seen, [m]."""
_THINNEST_M, _THICKEST_M = 0.006, 0.025
_ORIGIN: Point = (0.0, 0.0, 0.0)


def with_joins(bodies: Sequence[Body]) -> tuple[Body, ...]:
    """Return the bodies, those of a robot with rods from their shapes to their joints."""
    below = _with_shapes_below(bodies)
    rods: list[list[Shape]] = [[] for _ in bodies]
    for index, body in enumerate(bodies):
        if body.kind != "robot" or body.parent < 0 or not below[index]:
            continue
        parent = bodies[body.parent]
        # A root without shapes stands nowhere: what hangs on it is where the arm begins.
        if parent.kind == "robot" and (parent.shapes or parent.parent >= 0):
            rods[body.parent] += _rod(parent, body.xyz, body)
        if body.shapes:
            rods[index] += _rod(body, _ORIGIN, parent)
    return tuple(
        replace(body, shapes=(*body.shapes, *own)) if own else body
        for body, own in zip(bodies, rods, strict=True)
    )


def _with_shapes_below(bodies: Sequence[Body]) -> list[bool]:
    """Return for each body whether it, or one that hangs on it, can be seen."""
    shapes = [bool(body.shapes or body.triangles) for body in bodies]
    for index in range(len(bodies) - 1, -1, -1):
        parent = bodies[index].parent
        if parent >= 0 and shapes[index]:
            shapes[parent] = True
    return shapes


def _rod(body: Body, place: Point, other: Body) -> list[Shape]:
    """Return the rod from a body's shapes to a place in its frame; none where they reach it.

    A body without shapes has its rods meet in its origin.
    """
    near = min(
        (nearest_in(shape, place) for shape in body.shapes),
        key=lambda point: math.dist(point, place),
        default=_ORIGIN,
    )
    length = math.dist(near, place)
    if length < (GAP_M if body.shapes else 1e-6):
        return []
    (x, y, z), (to_x, to_y, to_z) = near, place
    radius = 0.4 * min(
        (_thin(shape) for shape in (*body.shapes, *other.shapes)), default=_THICKEST_M
    )
    return [
        Shape(
            "capsule",
            (min(max(radius, _THINNEST_M), _THICKEST_M), length / 2),
            ((x + to_x) / 2, (y + to_y) / 2, (z + to_z) / 2),
            (0.0, math.acos((to_z - z) / length), math.atan2(to_y - y, to_x - x)),
            contact=False,
        )
    ]


def nearest_in(shape: Shape, place: Point) -> Point:
    """Return the point of a shape that is nearest to a place, both in the frame of the body."""
    w, *turned = quaternion_of(shape.rpy)
    back = (w, -turned[0], -turned[1], -turned[2])
    x, y, z = rotated(back, [one - two for one, two in zip(place, shape.xyz, strict=True)])
    if shape.kind == "box":
        a, b, c = shape.size
        row = (_held(x, a), _held(y, b), _held(z, c))
    else:
        radius, half = (*shape.size, 0.0)[:2]
        middle = _held(z, half)
        from_axis = math.hypot(x, y, 0.0 if shape.kind == "cylinder" else z - middle)
        scale = radius / from_axis if from_axis > radius else 1.0
        rest = 0.0 if shape.kind == "cylinder" else (z - middle) * scale
        row = (x * scale, y * scale, middle + rest)
    a, b, c = rotated(quaternion_of(shape.rpy), row)
    return a + shape.xyz[0], b + shape.xyz[1], c + shape.xyz[2]


def _held(value: float, most: float) -> float:
    return min(max(value, -most), most)


def _thin(shape: Shape) -> float:
    """Return half of how thin a shape is, [m]."""
    return min(shape.size) if shape.kind == "box" else shape.size[0]
