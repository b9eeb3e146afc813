"""Vectors, points, quaternions, and poses and transforms as matrices (4, 4)."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3

from tracerisk.ros.homogeneous import turns
from tracerisk.ros.imports.exported import defined as _defined

from .registry import converts_from_numpy, converts_to_numpy


@converts_to_numpy(Vector3)
def vector3_to_numpy(msg: Any, hom: bool = False) -> Any:
    """Return x, y, z, and with `hom` a 0."""
    return np.array([msg.x, msg.y, msg.z, 0] if hom else [msg.x, msg.y, msg.z])


@converts_from_numpy(Vector3)
def numpy_to_vector3(arr: Any) -> Any:
    """Return vectors of (..., 3), or of (..., 4) that end in 0."""
    if arr.shape[-1] == 4:
        assert np.all(arr[..., -1] == 0)
        arr = arr[..., :-1]
    return _each(Vector3, "xyz", arr)


@converts_to_numpy(Point)
def point_to_numpy(msg: Any, hom: bool = False) -> Any:
    """Return x, y, z, and with `hom` a 1."""
    return np.array([msg.x, msg.y, msg.z, 1] if hom else [msg.x, msg.y, msg.z])


@converts_from_numpy(Point)
def numpy_to_point(arr: Any) -> Any:
    """Return points of (..., 3), or of (..., 4) in homogeneous coordinates."""
    if arr.shape[-1] == 4:
        arr = arr[..., :-1] / arr[..., -1:]
    return _each(Point, "xyz", arr)


@converts_to_numpy(Quaternion)
def quat_to_numpy(msg: Any) -> Any:
    """Return x, y, z, w."""
    return np.array([msg.x, msg.y, msg.z, msg.w])


@converts_from_numpy(Quaternion)
def numpy_to_quat(arr: Any) -> Any:
    """Return quaternions of (..., 4)."""
    assert arr.shape[-1] == 4
    return _each(Quaternion, "xyzw", arr)


@converts_to_numpy(Transform)
def transform_to_numpy(msg: Any) -> Any:
    """Return the matrix (4, 4)."""
    return _matrix(msg.translation, msg.rotation)


@converts_to_numpy(Pose)
def pose_to_numpy(msg: Any) -> Any:
    """Return the matrix (4, 4)."""
    return _matrix(msg.position, msg.orientation)


@converts_from_numpy(Transform)
def numpy_to_transform(arr: Any) -> Any:
    """Return transforms of (..., 4, 4)."""
    return _parts(arr, lambda place, turn: Transform(translation=place, rotation=turn), Vector3)


@converts_from_numpy(Pose)
def numpy_to_pose(arr: Any) -> Any:
    """Return poses of (..., 4, 4)."""
    return _parts(arr, lambda place, turn: Pose(position=place, orientation=turn), Point)


def _each(kind: Any, fields: str, arr: Any) -> Any:
    arr = np.asarray(arr)
    if arr.ndim == 1:
        return kind(**{name: float(v) for name, v in zip(fields, arr, strict=True)})
    made = np.empty(arr.shape[:-1], dtype=object)
    for index in np.ndindex(*arr.shape[:-1]):
        made[index] = _each(kind, fields, arr[index])
    return made


def _matrix(place: Any, turn: Any) -> Any:
    matrix = np.array(turns.quaternion_matrix([turn.x, turn.y, turn.z, turn.w]))
    matrix[:3, 3] = place.x, place.y, place.z
    return matrix


def _parts(arr: Any, make: Any, kind: Any) -> Any:
    assert arr.shape[-2:] == (4, 4)
    if arr.ndim == 2:
        quaternion = np.asarray(turns.quaternion_from_matrix(arr))
        return make(_each(kind, "xyz", arr[:3, 3]), numpy_to_quat(quaternion))
    made = np.empty(arr.shape[:-2], dtype=object)
    for index in np.ndindex(*arr.shape[:-2]):
        made[index] = _parts(arr[index], make, kind)
    return made


__all__ = _defined(globals())
