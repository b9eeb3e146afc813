"""The primitive that bounds a mesh most tightly."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import roll_pitch_yaw, triple
from tracerisk.common.geometry.shapes import Shape, ShapeKind

Array = NDArray[np.float64]

_THINNEST = 1e-4  # a primitive has at least this half length [m]


def bounding_shape(vertices: Array) -> Shape:
    """Return the smallest of the boxes, cylinders, capsules and balls that hold all vertices.

    vertices: (n, 3) [m]. They are tried along the axes of the mesh and along its principal axes.
    """
    points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    _, principal = np.linalg.eigh(np.cov(points.T) if len(points) > 1 else np.eye(3))
    pairs = [pair for axes in (np.eye(3), principal) for pair in _along(points, axes)]
    return min(pairs, key=lambda pair: pair[0])[1]


def _along(points: Array, axes: Array) -> Iterator[tuple[float, Shape]]:
    """Yield volume and shape of what bounds the points along some axes, the columns of `axes`."""
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turn = axes[:, order]
        if np.linalg.det(turn) < 0.0:
            turn = turn * np.array([1.0, 1.0, -1.0])
        local = points @ turn
        low, high = local.min(axis=0), local.max(axis=0)
        middle = (low + high) / 2
        half = np.maximum((high - low) / 2, _THINNEST)
        away = np.hypot(*(local - middle)[:, :2].T)
        radius = max(float(away.max()), _THINNEST)
        if order == (0, 1, 2):
            yield 8 * float(np.prod(half)), _shape("box", tuple(map(float, half)), middle, turn)
            ball = max(float(np.linalg.norm(local - middle, axis=1).max()), _THINNEST)
            yield 4 / 3 * math.pi * ball**3, _shape("sphere", (ball,), middle, turn)
        straight = float(half[2])
        size = (radius, straight)
        yield 2 * math.pi * radius**2 * straight, _shape("cylinder", size, middle, turn)
        # How far a ball's middle may be from the end of a vertex at `away` from the axis.
        caps = np.sqrt(np.maximum(radius**2 - away**2, 0.0))
        straight = max(float((np.abs(local[:, 2] - middle[2]) - caps).max()), _THINNEST)
        volume = 2 * math.pi * radius**2 * straight + 4 / 3 * math.pi * radius**3
        yield volume, _shape("capsule", (radius, straight), middle, turn)


def _shape(kind: ShapeKind, size: tuple[float, ...], middle: Array, turn: Array) -> Shape:
    return Shape(kind, size, triple(turn @ middle), roll_pitch_yaw(turn))
