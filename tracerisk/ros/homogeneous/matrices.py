"""Matrices (4, 4) of shifts, rotations, reflections, scalings, projections and shears.

Points and vectors may have three numbers or four; of the fourth nothing is taken.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tracerisk.ros.homogeneous.vectors import (
    EPS,
    Array,
    affine,
    direction_of,
    eigenvector,
    fixed_point,
    point_of,
)


def identity_matrix() -> Array:
    """Return the matrix that changes nothing."""
    return np.identity(4)


def translation_matrix(direction: ArrayLike) -> Array:
    """Return the matrix that shifts by a vector."""
    return affine(np.identity(3), point_of(direction))


def translation_from_matrix(matrix: ArrayLike) -> Array:
    """Return by what a matrix shifts: (3,)."""
    shift: Array = np.array(matrix, dtype=np.float64)[:3, 3].copy()
    return shift


def rotation_matrix(angle: float, direction: ArrayLike, point: ArrayLike | None = None) -> Array:
    """Return the rotation by an angle [rad] about an axis through a point (Rodrigues, 1840)."""
    x, y, z = axis = direction_of(direction)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = (
        math.cos(angle) * np.identity(3)
        + math.sin(angle) * cross
        + (1.0 - math.cos(angle)) * np.outer(axis, axis)
    )
    centre = point_of(point)
    return affine(turn, centre - turn @ centre)


def rotation_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array]:
    """Return angle [rad], axis (3,) and a point (4,) on the axis of a rotation.

    Raises:
        ValueError: the matrix is not a rotation about an axis.
    """
    given = np.asarray(matrix, dtype=np.float64)
    turn = given[:3, :3]
    axis = eigenvector(turn.T, 1.0)
    point = fixed_point(given)
    if axis is None or point is None:
        raise ValueError("no unit eigenvector corresponding to eigenvalue 1")
    # The part of the turn that changes sign with it is sin(angle) [axis]x.
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine, cosine = float(axis @ twice) / 2.0, (float(np.trace(turn)) - 1.0) / 2.0
    return math.atan2(sine, cosine), axis, point


def reflection_matrix(point: ArrayLike, normal: ArrayLike) -> Array:
    """Return the reflection in the plane through a point with a normal."""
    across = direction_of(normal)
    shift = 2.0 * float(point_of(point) @ across) * across
    return affine(np.identity(3) - 2.0 * np.outer(across, across), shift)


def reflection_from_matrix(matrix: ArrayLike) -> tuple[Array, Array]:
    """Return a point (4,) of a reflection's plane, and its normal (3,).

    Raises:
        ValueError: the matrix is no reflection.
    """
    given = np.asarray(matrix, dtype=np.float64)
    normal = eigenvector(given[:3, :3], -1.0)
    if normal is None:
        raise ValueError("no unit eigenvector corresponding to eigenvalue -1")
    point = fixed_point(given)
    if point is None:
        raise ValueError("no unit eigenvector corresponding to eigenvalue 1")
    return point, normal


def scale_matrix(
    factor: float, origin: ArrayLike | None = None, direction: ArrayLike | None = None
) -> Array:
    """Return the scaling by a factor about an origin, in one direction or in all."""
    centre = point_of(origin)
    if direction is None:
        linear = factor * np.identity(3)
    else:
        along = direction_of(direction)
        linear = np.identity(3) - (1.0 - factor) * np.outer(along, along)
    return affine(linear, centre - linear @ centre)


def scale_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array | None]:
    """Return factor, origin (4,) and direction (3,) of a scaling; None where it is in all.

    Raises:
        ValueError: the matrix is not a scaling.
    """
    given = np.asarray(matrix, dtype=np.float64)
    linear = given[:3, :3]
    factor = float(np.trace(linear)) - 2.0
    direction = eigenvector(linear, factor)
    if direction is None:
        factor = (factor + 2.0) / 3.0
    origin = fixed_point(given)
    if origin is None:
        raise ValueError("no eigenvector corresponding to eigenvalue 1")
    return factor, origin, direction


def projection_matrix(
    point: ArrayLike,
    normal: ArrayLike,
    direction: ArrayLike | None = None,
    perspective: ArrayLike | None = None,
    pseudo: bool = False,
) -> Array:
    """Return the projection onto the plane through a point with a normal.

    It is along `direction`, from the point `perspective`, or else orthogonal.
    `pseudo` keeps the depth of a perspective one.
    """
    place, across = point_of(point), direction_of(normal)
    height = float(place @ across)
    if perspective is not None:
        eye = point_of(perspective)
        matrix = np.identity(4)
        matrix[:3, :3] = float((eye - place) @ across) * np.identity(3) - np.outer(eye, across)
        matrix[:3, 3] = height * eye
        if pseudo:
            matrix[:3, :3] -= np.outer(across, across)
            matrix[:3, 3] += height * across
        matrix[3, :3], matrix[3, 3] = -across, float(eye @ across)
        return matrix
    along = across if direction is None else point_of(direction)
    scale = float(along @ across)
    return affine(np.identity(3) - np.outer(along, across) / scale, along * (height / scale))


def projection_from_matrix(
    matrix: ArrayLike, pseudo: bool = False
) -> tuple[Array, Array, Array | None, Array | None, bool]:
    """Return point (4,), normal (3,), direction (3,), perspective (3,) and pseudo of a projection.

    Raises:
        ValueError: the matrix is no projection.
    """
    given = np.asarray(matrix, dtype=np.float64)
    if not pseudo and float(np.linalg.norm(given[3, :3])) < EPS:
        point = fixed_point(given)
        direction = eigenvector(given[:3, :3], 0.0)
        normal = eigenvector(given[:3, :3].T, 0.0)
        if point is None or direction is None or normal is None:
            raise ValueError("no eigenvector corresponding to eigenvalue 0")
        return point, normal, direction, None, False
    # Up to a factor k the rows are d I - eye normal^T, with d the eye's height, and -normal^T.
    factor = float(np.linalg.norm(given[3, :3]))
    if factor < EPS:
        raise ValueError("no eigenvector not corresponding to eigenvalue 0")
    normal = -given[3, :3] / factor
    linear = given[:3, :3] / factor
    if pseudo:
        linear = linear + np.outer(normal, normal)
    above = float(given[3, 3]) / factor
    height = (float(np.trace(linear)) + above) / 3.0
    eye = height * normal - linear @ normal
    point = np.array([*((above - height) * normal), 1.0])
    return point, normal, None, eye, pseudo


def clip_matrix(
    left: float,
    right: float,
    bottom: float,
    top: float,
    near: float,
    far: float,
    perspective: bool = False,
) -> Array:
    """Return the matrix from a box or a frustum to the cube from -1 to 1.

    Raises:
        ValueError: the bounds are out of order, or a frustum begins behind the eye.
    """
    if left >= right or bottom >= top or near >= far:
        raise ValueError("invalid frustrum")
    width, height, depth = right - left, top - bottom, far - near
    if not perspective:
        return np.array(
            [
                [2.0 / width, 0.0, 0.0, -(right + left) / width],
                [0.0, 2.0 / height, 0.0, -(top + bottom) / height],
                [0.0, 0.0, 2.0 / depth, -(far + near) / depth],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    if near <= EPS:
        raise ValueError("invalid frustrum: near <= 0")
    return np.array(
        [
            [-2.0 * near / width, 0.0, (right + left) / width, 0.0],
            [0.0, -2.0 * near / height, (top + bottom) / height, 0.0],
            [0.0, 0.0, -(far + near) / depth, 2.0 * near * far / depth],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )


def shear_matrix(angle: float, direction: ArrayLike, point: ArrayLike, normal: ArrayLike) -> Array:
    """Return the shear by an angle [rad] along a direction in the plane through a point.

    Raises:
        ValueError: the direction does not lie in the plane.
    """
    along, across = direction_of(direction), direction_of(normal)
    if abs(float(along @ across)) > 1e-6:
        raise ValueError("direction and normal vectors are not orthogonal")
    tangent = math.tan(angle)
    shift = -tangent * float(point_of(point) @ across) * along
    return affine(np.identity(3) + tangent * np.outer(along, across), shift)


def shear_from_matrix(matrix: ArrayLike) -> tuple[float, Array, Array, Array]:
    """Return angle [rad], direction (3,), a point (4,) of the plane and normal (3,) of a shear.

    Raises:
        ValueError: the matrix is no shear.
    """
    given = np.asarray(matrix, dtype=np.float64)
    # A shear is the identity and tan(angle) direction normal^T, which has one singular value.
    left, sizes, right = np.linalg.svd(given[:3, :3] - np.identity(3))
    if sizes[0] < EPS or sizes[1] > 1e-4 * max(1.0, float(sizes[0])):
        raise ValueError(f"no two linear independent eigenvectors found {sizes}")
    point = fixed_point(given)
    if point is None:
        raise ValueError("no eigenvector corresponding to eigenvalue 1")
    return math.atan(float(sizes[0])), left[:, 0], point, right[0]
