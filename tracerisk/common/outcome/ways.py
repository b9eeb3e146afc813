"""Ways of a tool as lines between corners: fewer corners, and how far two ways lie apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

Point = tuple[float, float, float]


def corners(points: Sequence[Point], within_m: float) -> list[Point]:
    """Return the corners of a way, its ends left out: every point lies `within_m` of the lines [m].

    Source: D. Douglas, T. Peucker, "Algorithms for the reduction of the number of points required
    to represent a digitized line", Cartographica 10 (1973).
    """
    kept: set[int] = set()
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        far, corner = within_m, 0
        for place in range(first + 1, last):
            off = line_distance(points[place], points[first], points[last])
            if off > far:
                far, corner = off, place
        if corner:
            kept.add(corner)
            spans += [(first, corner), (corner, last)]
    return [points[place] for place in sorted(kept)]


def ways_apart(one: Sequence[Point], other: Sequence[Point]) -> float:
    """Return how far the corners of two ways, ends included, lie from the other way at most [m]."""
    return max(
        max((_way_distance(corner, other) for corner in one), default=0.0),
        max((_way_distance(corner, one) for corner in other), default=0.0),
    )


def _way_distance(point: Point, way: Sequence[Point]) -> float:
    return min(line_distance(point, begin, end) for begin, end in pairwise(way))


def line_distance(point: Point, begin: Point, end: Point) -> float:
    """Return the distance of a point from the line between two others [m]."""
    ax, ay, az = end[0] - begin[0], end[1] - begin[1], end[2] - begin[2]
    px, py, pz = point[0] - begin[0], point[1] - begin[1], point[2] - begin[2]
    length = ax * ax + ay * ay + az * az
    share = (ax * px + ay * py + az * pz) / length if length else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.hypot(px - share * ax, py - share * ay, pz - share * az)
