"""Where the bodies of a run are at a moment: from the values of joints to poses in the world."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tracerisk.common.geometry.rotation import Quaternion, Vector, product, quaternion_of, rotated
from tracerisk.common.geometry.shapes import Shape
from tracerisk.report.html.run.replay_model import Body


@dataclass(frozen=True, slots=True)
class Placed:
    """A pose in the world."""

    xyz: Vector
    """Position [m]."""
    quaternion: Quaternion
    """Orientation (w, x, y, z)."""

    def point(self, inside: Sequence[float]) -> Vector:
        """Return where a point of this frame is in the world [m]."""
        x, y, z = rotated(self.quaternion, inside)
        return self.xyz[0] + x, self.xyz[1] + y, self.xyz[2] + z

    def then(self, xyz: Sequence[float], turn: Quaternion) -> Placed:
        """Return a pose that is given in this frame."""
        return Placed(self.point(xyz), product(self.quaternion, turn))


WORLD = Placed((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def placed_bodies(bodies: Sequence[Body], values: Sequence[float]) -> tuple[Placed, ...]:
    """Return where each body is; `values` are the columns by which joints and free bodies move.

    A body stands after its parent. A hinge turns [rad], and a slide shifts [m], along its axis.
    """
    s: list[Placed] = []
    for body in bodies:
        parent = s[body.parent] if body.parent >= 0 else WORLD
        place = parent.then(body.xyz, body.quaternion)
        if body.joint == "free":
            x, y, z, *turn = (float(value) for value in values[body.column : body.column + 7])
            place = Placed((x, y, z), _unit((turn[0], turn[1], turn[2], turn[3])))
        elif body.joint == "hinge":
            half = float(values[body.column]) / 2
            x, y, z = (math.sin(half) * part for part in body.axis)
            place = place.then((0.0, 0.0, 0.0), (math.cos(half), x, y, z))
        elif body.joint == "slide":
            by = float(values[body.column])
            place = place.then([by * part for part in body.axis], (1.0, 0.0, 0.0, 0.0))
        s.append(place)
    return tuple(s)


def placed_shape(place: Placed, shape: Shape) -> Placed:
    """Return where a shape of a body is that is at `place`."""
    return place.then(shape.xyz, quaternion_of(shape.rpy))


def corners(place: Placed, shape: Shape) -> Iterator[Vector]:
    """Yield the corners of a box around a shape of a body that is at `place`."""
    radius, *more = shape.size
    match shape.kind:
        case "box":
            reach = (radius, *more)
        case "sphere":
            reach = (radius, radius, radius)
        case "capsule":
            reach = (radius, radius, more[0] + radius)
        case "cylinder":
            reach = (radius, radius, more[0])
    at = placed_shape(place, shape)
    for x in (-reach[0], reach[0]):
        for y in (-reach[1], reach[1]):
            for z in (-reach[2], reach[2]):
                yield at.point((x, y, z))


def _unit(turn: Quaternion) -> Quaternion:
    length = math.sqrt(sum(part * part for part in turn)) or 1.0
    return turn[0] / length, turn[1] / length, turn[2] / length, turn[3] / length
