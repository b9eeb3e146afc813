"""Lengths, unit vectors and random vectors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

EPS = float(np.finfo(float).eps) * 4.0
"""Below this a length is 0."""


def vector_norm(data: ArrayLike, axis: int | None = None, out: Array | None = None) -> Any:
    """Return the length of the vectors along `axis`, of all numbers without one.

    With `out` the lengths are written there and None is returned.
    """
    lengths = np.sqrt(np.sum(np.square(np.asarray(data, dtype=np.float64)), axis=axis))
    if out is None:
        return lengths
    out[...] = lengths
    return None


def unit_vector(data: ArrayLike, axis: int | None = None, out: Array | None = None) -> Any:
    """Return the vectors along `axis` at length 1; see `vector_norm` for `out`."""
    values = np.array(data, dtype=np.float64)
    lengths = np.sqrt(np.sum(np.square(values), axis=axis, keepdims=axis is not None))
    if out is None:
        return values / lengths
    out[...] = values / lengths
    return None


def random_vector(size: Any) -> Array:
    """Return random numbers in [0, 1) of the shape `size`."""
    return np.asarray(np.random.random(size), dtype=np.float64)


def point_of(point: ArrayLike | None) -> Array:
    """Return the first three numbers of a point, the origin for None: (3,)."""
    if point is None:
        return np.zeros(3)
    return np.asarray(point, dtype=np.float64)[:3]


def direction_of(vector: ArrayLike) -> Array:
    """Return the first three numbers of a vector at length 1: (3,)."""
    return np.asarray(unit_vector(np.asarray(vector, dtype=np.float64)[:3]))


def affine(linear: ArrayLike, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the matrix (4, 4) of a linear map (3, 3) and a shift (3,)."""
    matrix = np.identity(4)
    matrix[:3, :3], matrix[:3, 3] = linear, shift
    return matrix


def fixed_point(matrix: Array) -> Array | None:
    """Return the point nearest the origin that an affine map leaves where it is: (4,), or None."""
    left = np.identity(3) - matrix[:3, :3]
    point, *_ = np.linalg.lstsq(left, matrix[:3, 3], rcond=1e-9)
    if not np.allclose(left @ point, matrix[:3, 3], atol=1e-8):
        return None
    return np.array([*point, 1.0])


def eigenvector(matrix: Array, value: float) -> Array | None:
    """Return a real unit eigenvector of an eigenvalue, or None."""
    values, vectors = np.linalg.eig(matrix)
    near = np.flatnonzero(np.abs(values - value) < 1e-8)
    if not near.size:
        return None
    return np.asarray(unit_vector(np.real(vectors[:, near[-1]])))
