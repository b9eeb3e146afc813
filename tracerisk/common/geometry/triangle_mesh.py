"""Triangle meshes from STL (text or binary) and OBJ files."""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path

from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes

Vertex = tuple[float, float, float]
Triangle = tuple[int, int, int]

_FACET = struct.Struct("<12f2x")
_BINARY_HEADER = 84


def read_triangles(path: Path) -> tuple[list[Vertex], list[Triangle]]:
    """Return vertices and triangles (indices of vertices) of a mesh file.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is neither STL nor OBJ, or holds no triangle.
    """
    data = file_bytes(path, MOST_WRITTEN)
    if path.suffix.lower() == ".obj":
        vertices, triangles = _read_obj(data.decode("utf-8", "replace"))
    elif path.suffix.lower() == ".stl":
        corners = _stl_corners(data, path)
        numbers: dict[Vertex, int] = {}
        indices = [numbers.setdefault(corner, len(numbers)) for corner in corners]
        vertices = list(numbers)
        triangles = list(zip(indices[::3], indices[1::3], indices[2::3], strict=True))
    else:
        raise ValueError(f"{path}: unsupported mesh format '{path.suffix}'; allowed: .stl, .obj")
    if not triangles:
        raise ValueError(f"{path}: the mesh has no faces")
    return vertices, triangles


def _stl_corners(data: bytes, path: Path) -> list[Vertex]:
    if len(data) >= _BINARY_HEADER:
        (count,) = struct.unpack_from("<I", data, 80)
        if len(data) == _BINARY_HEADER + _FACET.size * count:
            corners: list[Vertex] = []
            for facet in _FACET.iter_unpack(data[_BINARY_HEADER:]):
                corners += [facet[3:6], facet[6:9], facet[9:12]]
            return corners
    lines = (line.split() for line in data.decode("utf-8", "replace").splitlines())
    stl_corners = [_vertex(words[1:4]) for words in lines if words[:1] == ["vertex"]]
    if len(stl_corners) % 3:
        raise ValueError(f"{path}: the STL file is truncated")
    return stl_corners


def _read_obj(text: str) -> tuple[list[Vertex], list[Triangle]]:
    vertices: list[Vertex] = []
    triangles: list[Triangle] = []
    for line in text.splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            vertices.append(_vertex(words[:3]))
        elif kind == "f":
            numbers = [int(word.split("/")[0]) for word in words]
            corners = [n - 1 if n > 0 else len(vertices) + n for n in numbers]
            # A face with more corners is a fan about its first.
            triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    return vertices, triangles


def _vertex(words: list[str]) -> Vertex:
    x, y, z = (float(word) for word in words)
    return (x, y, z)
