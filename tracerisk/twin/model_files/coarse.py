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
    cell = max(math.sqrt(area / max(most, 1)), _FINEST_M) if len(faces) > most else _FINEST_M
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
    _, group, count = np.unique(
        np.floor(vertices / cell).astype(np.int64), axis=0, return_inverse=True, return_counts=True
    )
    group = group.reshape(-1)
    means = np.zeros((len(count), 3))
    np.add.at(means, group, vertices)
    means /= count[:, None]
    mapped = group[faces]
    one, two, three = mapped.T
    mapped = mapped[(one != two) & (two != three) & (three != one)]
    # The same face may be left of several; its first corner is the smallest, its turn is kept.
    first = mapped.argmin(axis=1)[:, None]
    mapped = np.take_along_axis(mapped, (first + np.arange(3)) % 3, axis=1)
    mapped = np.unique(mapped, axis=0)
    used, renumbered = np.unique(mapped, return_inverse=True)
    return means[used], renumbered.reshape(-1, 3).astype(np.int64)
