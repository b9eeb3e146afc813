"""Frames of PyKDL, from and to poses, matrices (4, 4) and transforms of tf."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion
from numpy.typing import ArrayLike, NDArray
from PyKDL import Frame, Rotation, Vector

from tracerisk.ros.imports.exported import defined as _defined

Transform = tuple[tuple[float, float, float], tuple[float, float, float, float]]


def fromTf(tf: tuple[Sequence[float], Sequence[float]]) -> Any:
    """Return the frame of a position and a quaternion (x, y, z, w), as `lookupTransform` gives."""
    position, quaternion = tf
    return Frame(Rotation.Quaternion(*quaternion), Vector(*position))


def toTf(f: Any) -> Transform:
    """Return the position and the quaternion (x, y, z, w) of a frame."""
    return (f.p[0], f.p[1], f.p[2]), f.M.GetQuaternion()


def fromMsg(p: Any) -> Any:
    """Return the frame of a Pose."""
    turn, place = p.orientation, p.position
    return Frame(
        Rotation.Quaternion(turn.x, turn.y, turn.z, turn.w), Vector(place.x, place.y, place.z)
    )


def toMsg(f: Any) -> Any:
    """Return the Pose of a frame."""
    x, y, z, w = f.M.GetQuaternion()
    return Pose(
        position=Point(x=f.p[0], y=f.p[1], z=f.p[2]), orientation=Quaternion(x=x, y=y, z=z, w=w)
    )


def fromMatrix(m: ArrayLike) -> Any:
    """Return the frame of a matrix (4, 4)."""
    matrix = np.asarray(m, dtype=np.float64)
    return Frame(Rotation(*matrix[:3, :3].reshape(-1)), Vector(*matrix[:3, 3]))


def toMatrix(f: Any) -> NDArray[np.float64]:
    """Return the matrix (4, 4) of a frame."""
    rows = [[f[row, column] for column in range(4)] for row in range(3)]
    return np.array([*rows, [0.0, 0.0, 0.0, 1.0]])


def fromCameraParams(cv: Any, rvec: ArrayLike, tvec: ArrayLike) -> Any:
    """Return the frame of what OpenCV's `solvePnP` gives: axis times angle [rad], and a place.

    `cv`, the module of OpenCV, is not needed.
    """
    turn = Vector(*np.asarray(rvec, dtype=np.float64).reshape(3))
    place = Vector(*np.asarray(tvec, dtype=np.float64).reshape(3))
    return Frame(Rotation.Rot(turn, turn.Norm()), place)


__all__ = _defined(globals())
