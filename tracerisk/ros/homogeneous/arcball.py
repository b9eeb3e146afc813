"""Turning things by dragging on a ball (Shoemake, Graphics Gems IV, 1994)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tracerisk.ros.homogeneous.turns import (
    quaternion_from_matrix,
    quaternion_matrix,
    quaternion_multiply,
    quaternion_slerp,
)
from tracerisk.ros.homogeneous.vectors import EPS, Array, unit_vector


class Arcball:
    """A ball that is turned; `initial` is a quaternion or a rotation (4, 4).

    Raises:
        ValueError: `initial` is neither.
    """

    def __init__(self, initial: ArrayLike | None = None) -> None:
        self._axis: Array | None = None
        self._axes: list[Array] | None = None
        self._radius = 1.0
        self._center = [0.0, 0.0]
        self._vdown = np.array([0.0, 0.0, 1.0])
        self._constrain = False
        self._qdown = np.array([0.0, 0.0, 0.0, 1.0])
        if initial is not None:
            given = np.array(initial, dtype=np.float64)
            if given.shape == (4, 4):
                self._qdown = quaternion_from_matrix(given)
            elif given.shape == (4,):
                self._qdown = np.asarray(unit_vector(given))
            else:
                raise ValueError("initial not quaternion or matrix")
        self._qnow = self._qpre = self._qdown

    def place(self, center: Sequence[float], radius: float) -> None:
        """Place the ball in the window, with its radius [pixels]."""
        self._radius = float(radius)
        self._center = [float(center[0]), float(center[1])]

    def setaxes(self, *axes: ArrayLike) -> None:
        """Set the axes to which turns can be constrained; none of them ends that."""
        self._axes = [np.asarray(unit_vector(axis)) for axis in axes] or None

    def setconstrain(self, constrain: bool) -> None:
        """Return whether turns are constrained to the axes."""
        self._constrain = constrain is True

    def getconstrain(self) -> bool:
        """Return whether turns are constrained to the axes."""
        return self._constrain

    def down(self, point: Sequence[float]) -> None:
        """Begin to drag at a point of the window [pixels]."""
        self._vdown = arcball_map_to_sphere(point, self._center, self._radius)
        self._qdown = self._qpre = self._qnow
        self._axis = None
        if self._constrain and self._axes is not None:
            self._axis = arcball_nearest_axis(self._vdown, self._axes)
            self._vdown = arcball_constrain_to_axis(self._vdown, self._axis)

    def drag(self, point: Sequence[float]) -> None:
        """Drag to a point of the window [pixels]."""
        now = arcball_map_to_sphere(point, self._center, self._radius)
        if self._axis is not None:
            now = arcball_constrain_to_axis(now, self._axis)
        self._qpre = self._qnow
        across = np.cross(self._vdown, now)
        if across @ across < EPS:
            self._qnow = self._qdown
        else:
            turn = np.array([*across, self._vdown @ now])
            self._qnow = quaternion_multiply(turn, self._qdown)

    def next(self, acceleration: float = 0.0) -> None:
        """Go on in the direction of the last drag."""
        onward = quaternion_slerp(self._qpre, self._qnow, 2.0 + acceleration, 0)
        self._qpre, self._qnow = self._qnow, onward

    def matrix(self) -> Array:
        """Return the rotation: (4, 4)."""
        return quaternion_matrix(self._qnow)


def arcball_map_to_sphere(point: Sequence[float], center: Sequence[float], radius: float) -> Array:
    """Return the point of the unit ball under a point of the window: (3,)."""
    x, y = (point[0] - center[0]) / radius, (center[1] - point[1]) / radius
    square = x * x + y * y
    if square > 1.0:
        return np.array([x, y, 0.0]) / math.sqrt(square)
    return np.array([x, y, math.sqrt(1.0 - square)])


def arcball_constrain_to_axis(point: ArrayLike, axis: ArrayLike) -> Array:
    """Return the point of the ball nearest to another, on the circle about an axis: (3,)."""
    along = np.asarray(axis, dtype=np.float64)
    vector = np.asarray(point, dtype=np.float64)
    vector = vector - along * (along @ vector)
    length = float(np.linalg.norm(vector))
    if length > EPS:
        return np.asarray((-vector if vector[2] < 0.0 else vector) / length)
    if along[2] == 1.0:
        return np.array([1.0, 0.0, 0.0])
    return np.asarray(unit_vector([-along[1], along[0], 0.0]))


def arcball_nearest_axis(point: ArrayLike, axes: Sequence[ArrayLike]) -> Array:
    """Return the axis whose circle is nearest to a point of the ball: (3,)."""
    place = np.asarray(point, dtype=np.float64)
    return np.asarray(max(axes, key=lambda axis: arcball_constrain_to_axis(place, axis) @ place))
