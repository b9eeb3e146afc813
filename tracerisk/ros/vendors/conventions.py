"""The units and the turns of a driver's messages, and the quantities of the twin in SI units.

Turns: `rpy` about the fixed axes x, y, z; `rotation_vector` an axis whose length is the angle;
`euler_zyz` about z, then the new y, then the new z; `euler_xyz` likewise about x, y, z.
Formulas: Diebel, Representing Attitude, 2006.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from tracerisk.ros.transforms.poses import (
    Quaternion,
    conjugate,
    multiply,
    quaternion_from_rpy,
    rpy_from_quaternion,
    unit_quaternion,
)
from tracerisk.ros.vendors.description import UNITS, Rotation, Units
from tracerisk.twin.physics.motion import PlanningError, Pose

Dimension = Literal["angle", "length", "time", "plain"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """Numbers in SI units."""

    values: tuple[float, ...]
    """The numbers, (n,), [rad, m or s by their dimension]."""
    dimensions: tuple[Dimension, ...]
    """The dimension of each number, (n,)."""
    is_scalar: bool = False
    """Whether it is a single number and not a list of one."""


@dataclass(frozen=True, slots=True)
class Conventions:
    """The units and the form of rotations in a driver's messages."""

    units: Units = field(default_factory=Units)
    """The units of numbers that state none."""
    rotation: Rotation = "rpy"
    """The form of rotations."""

    def factor(self, dimension: Dimension, unit: str = "") -> float:
        """Return what one of a unit is in SI units; by default the driver's own unit."""
        if unit:
            return UNITS[unit]
        return 1.0 if dimension == "plain" else UNITS[getattr(self.units, dimension)]

    def numbers(self, quantity: Quantity, unit: str = "") -> list[float]:
        """Return a quantity as the numbers of a message."""
        pairs = zip(quantity.values, quantity.dimensions, strict=True)
        return [value / self.factor(dimension, unit) for value, dimension in pairs]

    def pose_numbers(self, pose: Pose, count: int | None = None) -> list[float]:
        """Return a pose as numbers: x, y, z and the turn; 7 of them hold a quaternion."""
        place = [value / self.factor("length") for value in pose.position]
        if count == 7 or (self.rotation == "quaternion" and count != 6):
            return [*place, *pose.orientation]
        return [*place, *self.turn_numbers(pose.orientation)]

    def turn_numbers(self, turn: Quaternion) -> list[float]:
        """Return a turn as its three numbers."""
        zyz: Sequence[float]
        if self.rotation == "rotation_vector":
            zyz = rotation_vector(turn)
        elif self.rotation == "euler_zyz":
            zyz = zyz_of(turn)
        elif self.rotation == "euler_xyz":
            # The turn back is one about fixed axes, by the same angles in the other order.
            zyz = [-value for value in rpy_from_quaternion(conjugate(turn))]
        else:
            zyz = rpy_from_quaternion(turn)
        return [value / self.factor("angle") for value in zyz]

    def pose(self, numbers: Sequence[float]) -> Pose:
        """Return the pose of 6 or 7 numbers.

        Raises:
            PlanningError: there are more or fewer, or one is not finite.
        """
        if len(numbers) not in (6, 7):
            raise PlanningError("bad_request", f"a pose has 6 values, not {len(numbers)}")
        if not all(math.isfinite(number) for number in numbers):
            raise PlanningError("bad_request", "a number of a pose is not finite")
        x, y, z = (number * self.factor("length") for number in numbers[:3])
        return Pose((x, y, z), self.turn(numbers[3:]))

    def turn(self, numbers: Sequence[float]) -> Quaternion:
        """Return the turn of three numbers, or of the four of a quaternion."""
        if len(numbers) == 4:
            return unit_quaternion(numbers)
        a, b, c = (number * self.factor("angle") for number in numbers)
        if self.rotation == "rotation_vector":
            return from_rotation_vector((a, b, c))
        if self.rotation == "euler_zyz":
            return from_zyz(a, b, c)
        if self.rotation == "euler_xyz":
            return conjugate(quaternion_from_rpy(-a, -b, -c))
        return quaternion_from_rpy(a, b, c)


def rotation_vector(turn: Quaternion) -> list[float]:
    """Return the axis of a turn, as long as its angle [rad]."""
    x, y, z, w = turn if turn[3] >= 0 else tuple(-value for value in turn)
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 if sine < 1e-12 else 2.0 * math.atan2(sine, w) / sine
    return [x * scale, y * scale, z * scale]


def from_rotation_vector(vector: Sequence[float]) -> Quaternion:
    """Return the turn about an axis by its length [rad]."""
    angle = math.hypot(*vector)
    scale = 0.5 if angle < 1e-12 else math.sin(angle / 2) / angle
    x, y, z = (value * scale for value in vector)
    return (x, y, z, math.cos(angle / 2))


def from_zyz(a: float, b: float, c: float) -> Quaternion:
    """Return the turn by `a` about z, `b` about the new y, `c` about the new z [rad]."""
    first = (0.0, 0.0, math.sin(a / 2), math.cos(a / 2))
    second = (0.0, math.sin(b / 2), 0.0, math.cos(b / 2))
    third = (0.0, 0.0, math.sin(c / 2), math.cos(c / 2))
    return multiply(multiply(first, second), third)


def zyz_of(turn: Quaternion) -> list[float]:
    """Return the three angles of `from_zyz`, the middle one in [0, pi]; the last is 0 at poles."""
    x, y, z, w = turn
    middle = 2.0 * math.atan2(math.hypot(x, y), math.hypot(z, w))
    total = 2.0 * math.atan2(z, w)
    if math.hypot(x, y) < 1e-9:
        return [total, 0.0, 0.0]
    apart = 2.0 * math.atan2(-x, y)
    if math.hypot(z, w) < 1e-9:
        return [apart, math.pi, 0.0]
    values = [(total + apart) / 2, middle, (total - apart) / 2]
    return [
        math.remainder(value, 2 * math.pi) if i != 1 else value for i, value in enumerate(values)
    ]
