"""Make a mesh coarse enough for a page, and pack it.

Vertices of one cell of a grid become one; the grid grows until few enough faces are left.
"""

from __future__ import annotations

import base64
import math
import struct

import numpy as np
from numpy.typing import NDArray

Vertices = NDArray[np.float64]
Faces = NDArray[np.int64]

MOST_FACES = 12_000
"""Faces of all meshes of a model together."""
_FEWEST_FACES = 200  # of one mesh
_FINEST_M = 2e-4
_GROWTH = 1.25
_MOST_QUANTA = 32_767


def most_faces(n_meshes: int) -> int:
    """Return how many faces one of so many meshes may keep."""
    return max(MOST_FACES // max(n_meshes, 1), _FEWEST_FACES)


def coarsened(vertices: Vertices, faces: Faces, most: int) -> tuple[Vertices, Faces]:
    """Return a mesh with at most `most` faces, vertices (n, 3) [m] and faces (m, 3)."""
    # Of a surface cut into cells two faces are left for each.
    one, two, three = (vertices[corners] for corners in faces.T)
    area = float(np.linalg.norm(np.cross(two - one, three - one), axis=1).sum()) / 2
    cell = max(math.sqrt(2 * area / max(most, 1)), _FINEST_M) if len(faces) > most else _FINEST_M
    kept, triangles = _clustered(vertices, faces, cell)
    while len(triangles) > most:
        cell *= _GROWTH
        kept, triangles = _clustered(vertices, faces, cell)
    return kept, triangles


def packed(vertices: Vertices, faces: Faces) -> str:
    """Return a mesh as `Mesh.packed` has it."""
    largest = float(np.abs(vertices).max(initial=1e-6))
    quantum = float(np.float32(largest / (_MOST_QUANTA - 1)))
    whole = np.rint(vertices / quantum).astype("<i2")
    head = struct.pack("<IIf", len(vertices), len(faces), quantum)
    return base64.b64encode(head + whole.tobytes() + faces.astype("<u2").tobytes()).decode("ascii")


def _clustered(vertices: Vertices, faces: Faces, cell: float) -> tuple[Vertices, Faces]:
    """Return the mesh whose vertices are the means of those in each cell of a grid [m]."""
    place = np.floor((vertices - vertices.min(axis=0)) / cell).astype(np.int64)
    _, group, count = np.unique(_keys(place), return_inverse=True, return_counts=True)
    sums = [np.bincount(group, column, len(count)) for column in vertices.T]
    means = np.stack(sums, axis=1) / count[:, None]
    mapped = group[faces]
    one, two, three = mapped.T
    mapped = mapped[(one != two) & (two != three) & (three != one)]
    # The same face may be left of several; its first corner is the smallest, its turn is kept.
    first = mapped.argmin(axis=1)[:, None]
    mapped = np.take_along_axis(mapped, (first + np.arange(3)) % 3, axis=1)
    mapped = mapped[np.sort(np.unique(_keys(mapped), return_index=True)[1])]
    used, renumbered = np.unique(mapped, return_inverse=True)
    return means[used], renumbered.reshape(-1, 3).astype(np.int64)


def _keys(rows: Faces) -> NDArray[np.int64]:
    """Return a number for each row of three numbers from 0 on, the same for the same row."""
    _, wide, deep = rows.max(axis=0, initial=0) + 1
    return np.asarray((rows[:, 0] * wide + rows[:, 1]) * deep + rows[:, 2])
