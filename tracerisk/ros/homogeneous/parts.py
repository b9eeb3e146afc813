"""Matrices (4, 4) taken apart and put together, inverted, compared and fitted to points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce

import numpy as np
from numpy.typing import ArrayLike

from tracerisk.ros.homogeneous.turns import euler_from_matrix, euler_matrix
from tracerisk.ros.homogeneous.vectors import EPS, Array, affine


def decompose_matrix(
    matrix: ArrayLike,
) -> tuple[Array, list[float], list[float], Array, Array]:
    """Return scale (3,), shear [xy, xz, yz], angles about static x, y, z [rad], shift, perspective.

    Raises:
        ValueError: the matrix has no scale of its own, or is singular.
    """
    given = np.array(matrix, dtype=np.float64)
    if abs(given[3, 3]) < EPS:
        raise ValueError("M[3, 3] is zero")
    given /= given[3, 3]
    flat = given.copy()
    flat[3] = 0.0, 0.0, 0.0, 1.0
    if not np.linalg.det(flat):
        raise ValueError("Matrix is singular")
    perspective = np.array([0.0, 0.0, 0.0, 1.0])
    if np.any(np.abs(given[3, :3]) > EPS):
        perspective = given[3] @ np.linalg.inv(flat)
    # Linear part = turn (orthonormal) times an upper triangle of scale and shear.
    turn, triangle = np.linalg.qr(flat[:3, :3])
    signs = np.where(np.diag(triangle) < 0.0, -1.0, 1.0)
    turn, triangle = turn * signs, signs[:, None] * triangle
    if np.linalg.det(turn) < 0.0:
        turn, triangle = -turn, -triangle
    scale = np.diag(triangle).copy()
    shear = [
        float(triangle[0, 1] / scale[1]),
        float(triangle[0, 2] / scale[2]),
        float(triangle[1, 2] / scale[2]),
    ]
    angles = list(euler_from_matrix(turn))
    return scale, shear, angles, flat[:3, 3].copy(), perspective


def compose_matrix(
    scale: Sequence[float] | None = None,
    shear: Sequence[float] | None = None,
    angles: Sequence[float] | None = None,
    translate: Sequence[float] | None = None,
    perspective: Sequence[float] | None = None,
) -> Array:
    """Return the matrix that scales, shears, turns, shifts and projects, in this order.

    `shear` is [xy, xz, yz], `angles` are about static x, y, z [rad].
    """
    matrix = np.identity(4)
    if perspective is not None:
        matrix[3, :] = np.asarray(perspective, dtype=np.float64)[:4]
    if translate is not None:
        matrix = matrix @ affine(np.identity(3), np.asarray(translate, dtype=np.float64)[:3])
    if angles is not None:
        matrix = matrix @ euler_matrix(angles[0], angles[1], angles[2], "sxyz")
    if shear is not None:
        sheared = np.identity(4)
        sheared[0, 1], sheared[0, 2], sheared[1, 2] = shear
        matrix = matrix @ sheared
    if scale is not None:
        matrix = matrix @ np.diag([scale[0], scale[1], scale[2], 1.0])
    return np.asarray(matrix / matrix[3, 3])


def orthogonalization_matrix(lengths: Sequence[float], angles: Sequence[float]) -> Array:
    """Return the matrix from crystallographic to Cartesian coordinates; `angles` in degrees."""
    a, b, c = lengths
    alpha, beta, gamma = np.radians(np.asarray(angles, dtype=np.float64))
    cosine = (math.cos(alpha) * math.cos(beta) - math.cos(gamma)) / (
        math.sin(alpha) * math.sin(beta)
    )
    return affine(
        (
            (a * math.sin(beta) * math.sqrt(1.0 - cosine * cosine), 0.0, 0.0),
            (-a * math.sin(beta) * cosine, b * math.sin(alpha), 0.0),
            (a * math.cos(beta), b * math.cos(alpha), c),
        )
    )


def superimposition_matrix(
    v0: ArrayLike, v1: ArrayLike, scaling: bool = False, usesvd: bool = True
) -> Array:
    """Return the rotation and shift, and scaling if asked for, that bring `v0` nearest to `v1`.

    Points stand in columns, (3, n) or (4, n); least squares by singular values (Kabsch, 1976),
    which give what the quaternions of `usesvd=False` give.

    Raises:
        ValueError: the shapes differ, or there are fewer than three points.
    """
    del usesvd
    begin = np.asarray(v0, dtype=np.float64)[:3]
    end = np.asarray(v1, dtype=np.float64)[:3]
    if begin.shape != end.shape or begin.shape[1] < 3:
        raise ValueError("Vectors are of wrong shape or type.")
    from_centre = begin.mean(axis=1, keepdims=True)
    to_centre = end.mean(axis=1, keepdims=True)
    begin, end = begin - from_centre, end - to_centre
    left, _, right = np.linalg.svd(end @ begin.T)
    sign = np.sign(np.linalg.det(left @ right))
    linear = left @ np.diag([1.0, 1.0, sign]) @ right
    if scaling:
        linear = linear * math.sqrt(float(np.sum(end * end) / np.sum(begin * begin)))
    return affine(linear, (to_centre - linear @ from_centre)[:, 0])


def inverse_matrix(matrix: ArrayLike) -> Array:
    """Return the matrix that undoes another."""
    return np.asarray(np.linalg.inv(np.asarray(matrix, dtype=np.float64)))


def concatenate_matrices(*matrices: ArrayLike) -> Array:
    """Return the product of matrices, of which the last acts first."""
    return reduce(np.dot, (np.asarray(matrix) for matrix in matrices), np.identity(4))


def is_same_transform(matrix0: ArrayLike, matrix1: ArrayLike) -> bool:
    """Return whether two matrices do the same to points."""
    first = np.array(matrix0, dtype=np.float64)
    second = np.array(matrix1, dtype=np.float64)
    return bool(np.allclose(first / first[3, 3], second / second[3, 3]))
