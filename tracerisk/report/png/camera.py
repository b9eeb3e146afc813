"""From where the pictures of a run are taken."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.common.geometry.rotation import Vector
from tracerisk.report.html.run.replay_model import Body
from tracerisk.report.png.placement import Placed, corners

_YAWS = tuple(math.pi * (step / 8 - 0.5) for step in range(1, 8))
"""From where a camera may look: from the half before the base [rad]."""
_PITCH = 0.40  # how far from above [rad]
FIELD = 0.62  # the camera's field of view across the height of the picture [rad]
_ASPECT = 1.5  # of the picture
_FILLED = 0.9  # of the picture, by the robot and the things about it
_ABOUT = 1.25  # things so many times as far from its middle as the robot goes are in the picture


@dataclass(frozen=True, slots=True)
class Camera:
    """Where a picture is taken from."""

    eye: tuple[float, float, float]
    """Position of the camera in the world [m]."""
    target: tuple[float, float, float]
    """Point that it looks at, in the world [m]."""
    field: float = FIELD
    """Angle of view across the height of the picture [rad]."""


def camera_of(bodies: Sequence[Body], pictures: Sequence[Sequence[Placed]]) -> Camera:
    """Return a camera that sees the whole robot in every picture, and things about it.

    It looks from where the arm is widest, so that its links hide each other least.
    """
    robot = _corners(bodies, pictures, "robot")
    low, high = ([pick(axis) for axis in zip(*robot, strict=True)] for pick in (min, max))
    middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    reach = _ABOUT * max(math.dist(middle, row) for row in robot)
    things = [*_corners(bodies, pictures, "object"), *_corners(bodies, pictures, "declared")]
    seen = [*robot, *(thing for thing in things if math.dist(middle, thing) <= reach)]
    yaw = max(
        _YAWS, key=lambda value: (round(_width(bodies, pictures, value), 6), -abs(value - 0.4))
    )
    right, up, back = _axes(yaw)
    spans = []
    for axis in (right, up, back):
        along = [_dot(axis, point) for point in seen]
        spans.append((min(along) + max(along)) / 2)
    target = [spans[0] * right[i] + spans[1] * up[i] + spans[2] * back[i] for i in range(3)]
    high_tan = math.tan(FIELD / 2) * _FILLED
    distance = 0.0
    for point in seen:
        x, y, z = (
            _dot(axis, point) - span for axis, span in zip((right, up, back), spans, strict=True)
        )
        distance = max(distance, z + abs(x) / (high_tan * _ASPECT), z + abs(y) / high_tan)
    eye = [t + distance * b for t, b in zip(target, back, strict=True)]
    return Camera((eye[0], eye[1], eye[2]), (target[0], target[1], target[2]))


def _axes(yaw: float) -> tuple[Vector, Vector, Vector]:
    """Return where right, up and towards the camera are for one that stands at `yaw`."""
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(_PITCH), math.sin(_PITCH)
    return (-sy, cy, 0.0), (-sp * cy, -sp * sy, cp), (cp * cy, cp * sy, sp)


def _width(bodies: Sequence[Body], pictures: Sequence[Sequence[Placed]], yaw: float) -> float:
    """Return how far apart a camera sees the links beside each other, summed over the pictures."""
    right, _, _ = _axes(yaw)
    total = 0.0
    for places in pictures:
        along = [
            _dot(right, place.xyz)
            for body, place in zip(bodies, places, strict=True)
            if body.kind == "robot"
        ]
        mean = sum(along) / len(along)
        total += math.sqrt(sum((value - mean) ** 2 for value in along) / len(along))
    return total


def _corners(
    bodies: Sequence[Body], pictures: Sequence[Sequence[Placed]], kind: str
) -> list[Vector]:
    return [
        corner
        for places in pictures
        for body, place in zip(bodies, places, strict=True)
        if body.kind == kind
        for shape in body.shapes
        for corner in corners(place, shape)
    ]


def _dot(one: Sequence[float], other: Sequence[float]) -> float:
    return sum(a * b for a, b in zip(one, other, strict=True))
