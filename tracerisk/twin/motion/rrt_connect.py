"""Find a free path from joint positions to one of several others: RRT-Connect with shortcuts.

J. Kuffner and S. LaValle, "RRT-Connect: an efficient approach to single-query path planning",
ICRA 2000: two trees grow towards random samples and greedily towards one another. That of the
goals has a root at each.
Bounded by numbers of iterations and of looks at a rule, not by time, so that a plan does not
depend on the machine.
Where a rule must be kept to, new points are projected onto it: D. Berenson and others,
"Manipulation planning on constraint manifolds", ICRA 2009.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RESOLUTION = 0.04
"""Between two checked points of a search, in the joint that moves most [rad or m]."""
FINE = 0.01
"""The same of a path that is found: what is thin may lie between the points of a search."""
_REACH = 0.8  # by which a tree grows at once [rad or m]
_RULED_REACH = 0.1  # the same where a rule is to be kept: it bends the way between two points
_PROGRESS = 0.1  # of its reach, by which a projected step must still come nearer
_PROJECTIONS = 12  # steps of one projection
_SLOPE_STEP = 1e-5  # by which a joint is moved to see how a rule changes [rad or m]
ITERATIONS = 3000
"""Of one search, unless others are given."""
LOOKS = 15_000
"""At a rule, in one search: some seconds, as long as MoveIt plans by default."""
_SHORTCUTS = 60
_SMOOTHINGS = 4
_FINE = 0.02  # between two points of the path returned [rad or m]

IsFree = Callable[[Array], bool]
Excess = Callable[[Array], Array]


def segment_is_free(a: Array, b: Array, is_free: IsFree, resolution: float = RESOLUTION) -> bool:
    """Return whether the straight way from `a`, left out, to `b` is free; a, b: (n_joints,)."""
    count = max(1, math.ceil(float(np.abs(b - a).max()) / resolution))
    # The middle first, then quarters: what is in the way is found sooner than from one end on.
    return all(is_free(a + (k / count) * (b - a)) for k in _halving(count))


def connect(
    start: Array,
    goals: Sequence[Array],
    lower: Array,
    upper: Array,
    is_free: IsFree,
    excess: Excess | None = None,
    *,
    iterations: int = ITERATIONS,
    resolution: float = RESOLUTION,
    most_looks: int = LOOKS,
) -> list[Array] | None:
    """Return a free path from `start` to one of `goals` within limits, None where none was found.

    start, goals, lower, upper: (n_joints,) [rad or m]; start and goals are free.
    `excess` returns by how much a position breaks a rule, each part with its sign: (n_parts,);
    after `most_looks` at it the search ends.
    The path is dense: its points are near one another, and its corners are rounded where there
    is room. The same arguments give the same path.
    """
    generator = np.random.default_rng(0)
    project = None if excess is None else _Projection(excess, lower, upper)
    ours, others = (_Tree(roots, resolution, project) for roots in ([start], goals))
    forward = True
    for _ in range(iterations):
        if project is not None and project.looks > most_looks:
            break
        sample = generator.uniform(lower, upper)
        reached = ours.grow(sample, is_free)
        if reached is not None:
            met = others.grow_to(ours.points[reached], is_free)
            if met is not None:
                one, two = ours.way_to(reached), others.way_to(met)
                path = [*one, *two[::-1][1:]] if forward else [*two, *one[::-1][1:]]
                return _rounded(_shortened(path, generator, is_free, resolution), is_free)
        ours, others = others, ours
        forward = not forward
    return None


def _far(a: Array, b: Array) -> float:
    return float(np.abs(a - b).max())


class _Projection:
    """Brings a position to where a rule is kept, by steps of Gauss and Newton."""

    def __init__(self, excess: Excess, lower: Array, upper: Array) -> None:
        self._excess = excess
        self._lower = lower
        self._upper = upper
        self.looks = 0

    def __call__(self, position: Array) -> Array | None:
        """Return a position near by that keeps the rule, None where none was found."""
        here = position
        for _ in range(_PROJECTIONS):
            error = self._excess(here)
            self.looks += 1 + len(here)
            if not np.isfinite(error).all():
                return None
            if not error.any():
                return here
            slope = np.empty((len(error), len(here)))
            for joint in range(len(here)):
                moved = here.copy()
                moved[joint] += _SLOPE_STEP
                slope[:, joint] = (self._excess(moved) - error) / _SLOPE_STEP
            step = np.linalg.lstsq(slope, error, rcond=1e-6)[0]
            longest = float(np.abs(step).max())
            if not longest > 0.0:
                return None
            here = np.clip(here - step * min(1.0, _REACH / longest), self._lower, self._upper)
        return None


class _Tree:
    """Trees of free positions, each joined to its parent by a free straight line."""

    def __init__(
        self, roots: Sequence[Array], resolution: float, project: _Projection | None
    ) -> None:
        self.points: list[Array] = []
        self._resolution = resolution
        self._project = project
        self._reach = _REACH if project is None else _RULED_REACH
        self._parents: list[int] = []
        self._table = np.empty((64, len(roots[0])))
        for root in roots:
            self._add(root, -1)

    def grow(self, target: Array, is_free: IsFree) -> int | None:
        """Return the new point after a step towards `target`, None where it is blocked."""
        nearest = self._nearest(target)
        here = self.points[nearest]
        delta = target - here
        far = float(np.abs(delta).max())
        there = target if far <= self._reach else here + delta * (self._reach / far)
        if self._project is not None and not is_free(there):
            projected = self._project(there)
            # What leads back, or no nearer, would go on for ever.
            if projected is None or _far(projected, target) > far - _PROGRESS * self._reach:
                return None
            there = projected
        if not segment_is_free(here, there, is_free, self._resolution):
            return None
        return self._add(there, nearest)

    def grow_to(self, target: Array, is_free: IsFree) -> int | None:
        """Return the point at `target` after as many steps as it takes, None where blocked."""
        while True:
            at = self.grow(target, is_free)
            if at is None:
                return None
            if self.points[at] is target:
                return at

    def way_to(self, index: int) -> list[Array]:
        """Return the points from a root to a point."""
        way = []
        while index >= 0:
            way.append(self.points[index])
            index = self._parents[index]
        return way[::-1]

    def _nearest(self, target: Array) -> int:
        distances = np.square(self._table[: len(self.points)] - target).sum(axis=1)
        return int(distances.argmin())

    def _add(self, point: Array, parent: int) -> int:
        index = len(self.points)
        if index == len(self._table):
            self._table = np.concatenate((self._table, np.empty_like(self._table)))
        self._table[index] = point
        self.points.append(point)
        self._parents.append(parent)
        return index


def _shortened(
    path: list[Array], generator: np.random.Generator, is_free: IsFree, resolution: float
) -> list[Array]:
    """Replace stretches of the path by straight lines where these are free."""
    for _ in range(_SHORTCUTS):
        if len(path) < 3:
            break
        # Two places on the path, by length, so that a corner is cut wherever it stands.
        lengths = np.array([np.linalg.norm(b - a) for a, b in pairwise(path)])
        ends = np.concatenate(([0.0], np.cumsum(lengths)))
        low, high = sorted(generator.uniform(0.0, ends[-1], 2))
        i, a = _point_at(path, ends, low)
        j, b = _point_at(path, ends, high)
        if i != j and segment_is_free(a, b, is_free, resolution):
            path = [*path[: i + 1], a, b, *path[j + 1 :]]
    return path


def _point_at(path: list[Array], ends: Array, length: float) -> tuple[int, Array]:
    i = min(int(np.searchsorted(ends, length, side="right")) - 1, len(path) - 2)
    part = (length - ends[i]) / max(float(ends[i + 1] - ends[i]), 1e-12)
    return i, path[i] + part * (path[i + 1] - path[i])


def _rounded(path: list[Array], is_free: IsFree) -> list[Array]:
    """Cut the path into small steps and round its corners as far as there is room."""
    points = [path[0]]
    for a, b in pairwise(path):
        count = max(1, math.ceil(float(np.abs(b - a).max()) / _FINE))
        points += [a + (k / count) * (b - a) for k in range(1, count + 1)]
    dense = np.array(points)
    for _ in range(_SMOOTHINGS):
        wide = min(4, (len(dense) - 1) // 2)
        if wide < 1:
            break
        padded = np.concatenate(
            (np.repeat(dense[:1], wide, axis=0), dense, np.repeat(dense[-1:], wide, axis=0))
        )
        shifted = [padded[k : k + len(dense)] for k in range(2 * wide + 1)]
        smooth: Array = np.mean(shifted, axis=0)
        smooth[0], smooth[-1] = dense[0], dense[-1]
        # Points between, too: the arm passes there, and the path may graze something.
        between = (smooth[1:] + smooth[:-1]) / 2
        if not all(is_free(point) for point in (*smooth, *between)):
            break
        dense = smooth
    return list(dense)


def _halving(count: int) -> list[int]:
    """Return 1..count, the end first, then middles of ever shorter stretches."""
    order, stretches = [count], [(0, count)]
    while stretches:
        longer = []
        for low, high in stretches:
            if high - low > 1:
                middle = (low + high) // 2
                order.append(middle)
                longer += [(low, middle), (middle, high)]
        stretches = longer
    return order
