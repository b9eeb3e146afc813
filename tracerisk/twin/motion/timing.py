"""Put a path of joint positions in time: as fast as limits of velocity and acceleration allow.

Source: T. Kunz and M. Stilman, "Time-optimal trajectory generation for path following with
bounded acceleration and velocity", Robotics: Science and Systems 2012, the method that MoveIt
times plans with (TOTG). The path is straight from point to point, with circular arcs that blend
the corners. Along its length s the squared speed x = (ds/dt)^2 has to satisfy |q'| sqrt(x) <= v
and |q' u + q'' x| <= a of every joint, with u = (dx/ds)/2. The path is cut into cells of constant
u; where the limits reverse, a pass from the end to the start finds how fast each cell may be
entered, and a pass from the start speeds up as hard as that allows: H. Pham and Q.-C. Pham, "A new
approach to time-optimal path parameterization based on reachability analysis", IEEE Transactions
on Robotics 2018. It finds the same trajectory as a search for switching points, which can fail.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.motion.interpolation import resample

Array = NDArray[np.float64]

PATH_TOLERANCE = 0.1  # by which a blend may leave a corner, over all joints [rad or m]
RESAMPLE_S = 0.1  # between two points of a timed path, at most [s]
MIN_ANGLE_CHANGE = 0.001  # a point nearer than this to the last one is dropped [rad or m]
_MOST_POINTS = 2001  # of a path however slow, beside those where its acceleration changes
_ARC_STEP = 0.06  # the turn of a blend within one cell, at most [rad]
_STRAIGHT = 0.999999  # cosine of the turn of a corner that needs no blend
_REVERSAL = -0.99999  # cosine of the turn at which a path goes back: it stops there
_SHARP = 1e-4  # by which a blend leaves a corner where there is no room [rad or m]
_PASSED = 0.01  # between two points that are looked at, on average [rad or m]
_TINY = 1e-9
_LEAST_S = 2e-9  # between two points [s]


@dataclass(frozen=True, slots=True)
class _Blended:
    """A path of straight pieces and arcs; arrays have a row a piece.

    A straight piece has `radius` 0, begins at `origin` and goes along `forward`. An arc lies
    around `origin`, begins at `origin + radius * outward` and goes along `forward` there.
    """

    begin: Array
    """Length along the path at the start of each piece, (n_pieces,)."""
    length: Array
    """Length of each piece, (n_pieces,)."""
    radius: Array
    """Radius of each arc, 0 of a straight piece, (n_pieces,)."""
    origin: Array
    """Start of each straight piece or centre of each arc, (n_pieces, n_joints)."""
    outward: Array
    """Unit vector from the centre to the start of each arc, (n_pieces, n_joints)."""
    forward: Array
    """Unit tangent at the start of each piece, (n_pieces, n_joints)."""
    stops: NDArray[np.bool_]
    """Whether the path reverses at the start of each piece, (n_pieces,)."""

    def at(self, piece: NDArray[np.intp], s: Array) -> tuple[Array, Array, Array]:
        """Return position, tangent and curvature, (n, n_joints), at lengths s (n,) in pieces."""
        local, radius = s - self.begin[piece], self.radius[piece]
        bent = radius > 0.0
        inverse = np.where(bent, 1.0 / np.where(bent, radius, 1.0), 0.0)
        angle = (local * inverse).tolist()
        cosine = np.array([math.cos(item) for item in angle])[:, None]
        sine = np.array([math.sin(item) for item in angle])[:, None]
        outward, forward = self.outward[piece], self.forward[piece]
        towards = outward * cosine + forward * sine
        straight = np.where(bent, 0.0, local)[:, None]
        position = self.origin[piece] + radius[:, None] * towards + straight * forward
        tangent = np.where(bent[:, None], forward * cosine - outward * sine, forward)
        return position, tangent, -inverse[:, None] * towards


def along_path(
    path: Array,
    velocity: Array,
    acceleration: Array,
    *,
    tolerance: float | Array = PATH_TOLERANCE,
    resample_s: float = RESAMPLE_S,
    min_angle_change: float = MIN_ANGLE_CHANGE,
) -> tuple[Array, Array, Array]:
    """Return time, position and velocity along a path, at rest at both ends.

    path: (n_points, n_joints) [rad or m], followed in straight lines; at each point between, an
    arc blends them that leaves it by `tolerance` at most and begins and ends no further from it
    than half way to its neighbours. Where the path goes back on itself it comes to rest.
    tolerance: of all points, or (n_points,) of each [rad or m].
    velocity, acceleration: (n_joints,), absolute and already scaled.
    `resample_s` [s] is the longest time between two points returned, `min_angle_change`
    [rad or m] how far some joint must be from one point of the path to the next that counts.
    Returns time (m,) [s] and position, velocity (m, n_joints), with which a cubic between two
    points keeps the limits: there is a point wherever the acceleration changes.
    """
    tolerances = np.broadcast_to(np.asarray(tolerance, dtype=np.float64), len(path))
    points, kept = _distinct(path, max(min_angle_change, _TINY))
    if len(points) == 1:
        return np.zeros(1), points, np.zeros_like(points)
    blended = _blended(points, tolerances[kept][1:-1])
    piece, s = _cells(blended)
    squared = _fastest(blended, piece, s, velocity, acceleration)
    piece, s, squared = _with_peaks(blended, piece, s, squared, velocity, acceleration)
    piece, s, speed, time = _sampled(piece, s, squared, resample_s)
    position, tangent, _ = blended.at(piece, s)
    position[0], position[-1] = points[0], points[-1]
    return time, position, tangent * speed[:, None]


def along_free_path(
    path: Sequence[Array] | Array,
    velocity: Array,
    acceleration: Array,
    is_free: Callable[[Array], bool],
    *,
    tolerance: float = PATH_TOLERANCE,
    resample_s: float = RESAMPLE_S,
    min_angle_change: float = MIN_ANGLE_CHANGE,
) -> tuple[Array, Array, Array]:
    """Return what `along_path` returns, with corners not blended whose blend is not free.

    `is_free` says of positions (n_joints,) whether they are; the path itself is, or is followed
    all the same.
    """
    points = np.array(path)
    tolerances = np.full(len(points), tolerance)
    while True:
        timed = along_path(
            points,
            velocity,
            acceleration,
            tolerance=tolerances,
            resample_s=resample_s,
            min_angle_change=min_angle_change,
        )
        if len(points) < 3:
            return timed
        caught = [position for position in _passed(*timed) if not is_free(position)]
        apart = [np.abs(points[1:-1] - position).max(axis=1) for position in caught]
        corners = sorted({1 + int(far.argmin()) for far in apart})
        corners = [corner for corner in corners if tolerances[corner] > _SHARP]
        if not corners:
            return timed
        tolerances[corners] = _SHARP


def _passed(time: Array, position: Array, velocity: Array) -> Array:
    """Return where the joints pass, points near one another: (n, n_joints)."""
    longest = float(np.abs(np.diff(position, axis=0)).sum(axis=0).max(initial=0.0))
    if not longest > 0.0:
        return position
    step_s = float(time[-1]) / math.ceil(longest / _PASSED)
    between, _ = resample(time, position, velocity, step_s)
    return np.concatenate((position, between))


def _distinct(path: Array, change: float) -> tuple[Array, list[int]]:
    """Return the points that differ, with the first and the last, (m, n_joints), and which."""
    kept = [0]
    for index in range(1, len(path) - 1):
        if float(np.abs(path[index] - path[kept[-1]]).max()) > change:
            kept.append(index)
    last = len(path) - 1
    apart = float(np.abs(path[last] - path[kept[-1]]).max())
    if len(kept) > 1 and apart <= change:
        kept[-1] = last
    elif apart > _TINY:
        kept.append(last)
    return path[kept], kept


def _blended(points: Array, tolerance: Array) -> _Blended:
    """Return the path through points whose corners are left by (n_points - 2,) at most."""
    delta = np.diff(points, axis=0)
    length = np.sqrt(np.square(delta).sum(axis=1))
    ahead = delta / length[:, None]
    cosine = (ahead[:-1] * ahead[1:]).sum(axis=1)
    turns = (cosine <= _STRAIGHT) & (cosine > _REVERSAL)
    half = np.array([math.acos(c) / 2 if t else 0.5 for c, t in zip(cosine, turns, strict=True)])
    tangent = np.array([math.tan(item) for item in half.tolist()])
    # From the corner to where the blend begins: half way to the nearer neighbour at most.
    # sin h / (1 - cos h) = 1 / tan(h / 2) is that distance for a blend 1 off its corner.
    wide = tolerance / np.array([math.tan(item / 2) for item in half.tolist()])
    cut = np.where(turns, np.minimum(np.minimum(length[:-1], length[1:]) / 2, wide), 0.0)
    radius = np.where(turns, cut / tangent, 1.0)
    apart = ahead[1:] - ahead[:-1]
    wideness = np.sqrt(np.square(apart).sum(axis=1))[:, None]
    inward = apart / np.where(turns[:, None], wideness, 1.0)
    centre = points[1:-1] + inward * (np.hypot(radius, cut))[:, None]
    outward = (points[1:-1] - cut[:, None] * ahead[:-1] - centre) / radius[:, None]
    # A straight piece, the blend after it, the next straight piece, and so on.
    count, none = 2 * len(length) - 1, np.zeros(1)
    pieces = np.zeros(count)
    pieces[0::2] = length - np.concatenate((none, cut)) - np.concatenate((cut, none))
    pieces[1::2] = np.where(turns, 2 * half * radius, 0.0)
    radii = np.zeros(count)
    radii[1::2] = radius
    origin, out, forward = (np.zeros((count, points.shape[1])) for _ in range(3))
    origin[0::2] = points[:-1] + np.concatenate((none, cut))[:, None] * ahead
    origin[1::2] = centre
    out[1::2] = outward
    forward[0::2], forward[1::2] = ahead, ahead[:-1]
    stops = np.zeros(count, dtype=bool)
    stops[2::2] = cosine <= _REVERSAL
    kept = pieces > 1e-6
    kept[0::2] |= ~np.concatenate((turns, [False])) & ~np.concatenate(([False], turns))
    begin = np.concatenate((none, np.cumsum(pieces[kept])[:-1]))
    return _Blended(
        begin, pieces[kept], radii[kept], origin[kept], out[kept], forward[kept], stops[kept]
    )


def _cells(path: _Blended) -> tuple[NDArray[np.intp], Array]:
    """Return the piece of each cell, (n_cells,), and the lengths at their ends, (n_cells + 1,)."""
    bent = path.radius > 0.0
    turn = np.where(bent, path.length / np.where(bent, path.radius, 1.0), 0.0)
    count = np.maximum(1, np.ceil(turn / _ARC_STEP)).astype(np.intp)
    piece = np.repeat(np.arange(len(count)), count)
    before = np.cumsum(count) - count
    nth = np.arange(len(piece)) - before[piece]
    s = path.begin[piece] + path.length[piece] * (nth / count[piece])
    return piece, np.append(s, path.begin[-1] + path.length[-1])


def _fastest(
    path: _Blended, piece: NDArray[np.intp], s: Array, velocity: Array, acceleration: Array
) -> Array:
    """Return the squared speeds at the ends of the cells, (n_cells + 1,), 0 at both ends."""
    width = np.diff(s)
    _, tangent, curvature = path.at(piece, (s[:-1] + s[1:]) / 2)
    ceiling = np.full(len(s), np.inf)
    for at, cells in ((s[:-1], slice(None, -1)), (s[1:], slice(1, None))):
        _, there, _ = path.at(piece, at)
        ceiling[cells] = np.minimum(ceiling[cells], _by_velocity(there, velocity))
    by_middle = _by_velocity(tangent, velocity)
    ceiling[:-1] = np.minimum(ceiling[:-1], by_middle)
    ceiling[1:] = np.minimum(ceiling[1:], by_middle)
    # Half way along a cell the squared speed is x + width * u, so the limits are
    # -a <= slope u + bend x <= a there; divided by |slope|, low - pull x <= u <= high - pull x.
    slope = tangent + width[:, None] * curvature
    steep = np.maximum(np.abs(slope), _TINY)
    pull = np.where(slope < 0.0, -curvature, curvature) / steep
    high = acceleration / steep
    # -high - pull x <= high - pull x of any two joints, and the speed at the end is not negative.
    lower = np.hstack((pull, 1.0 / (2 * width)[:, None]))
    floor = np.hstack((high, np.zeros((len(width), 1))))
    falling = pull[:, :, None] - lower[:, None, :]
    room = high[:, :, None] + floor[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        by_curvature = np.where(falling > 0.0, room / falling, np.inf).min(axis=(1, 2))
        # The speed at which u = -high - pull x slows to `end` within the cell: (end + d) * e.
        d = 2 * width[:, None] * high
        e = 1.0 - 2 * width[:, None] * pull
        e = np.where(e > 0.0, 1.0 / e, np.inf)
    ceiling[:-1] = np.minimum(ceiling[:-1], by_curvature)
    begins = np.concatenate(([True], np.diff(piece) > 0))
    ceiling[:-1][begins & path.stops[piece]] = 0.0
    ceiling[0] = ceiling[-1] = 0.0
    entry = ceiling.tolist()
    for i in range(len(width) - 1, -1, -1):
        entry[i] = min(entry[i], float(((entry[i + 1] + d[i]) * e[i]).min()))
    twice = (2 * width).tolist()
    for i in range(len(width)):
        gain = float((high[i] - pull[i] * entry[i]).min())
        entry[i + 1] = min(entry[i + 1], max(0.0, entry[i] + twice[i] * gain))
    return np.array(entry)


def _by_velocity(tangent: Array, velocity: Array) -> Array:
    squared: Array = np.square((velocity / np.maximum(np.abs(tangent), _TINY)).min(axis=1))
    return squared


def _with_peaks(
    path: _Blended,
    piece: NDArray[np.intp],
    s: Array,
    squared: Array,
    velocity: Array,
    acceleration: Array,
) -> tuple[NDArray[np.intp], Array, Array]:
    """Return cells, lengths and squared speeds with straight pieces cut where u changes.

    A straight piece is sped up, cruised along at the limit of velocity, and slowed down.
    """
    lines = np.flatnonzero(path.radius[piece] == 0.0)
    forward = path.forward[piece[lines]]
    top = _by_velocity(forward, velocity)
    rate = 2 * (acceleration / np.maximum(np.abs(forward), _TINY)).min(axis=1)
    begin, end = squared[lines], squared[lines + 1]
    width = s[lines + 1] - s[lines]
    peak = np.maximum(np.minimum(top, (begin + end + rate * width) / 2), np.maximum(begin, end))
    up, down = (peak - begin) / rate, (peak - end) / rate
    least = 1e-9 * width
    # From rest to rest there is a peak in between, however near to an end.
    first = ((up > least) | (begin + end == 0.0)) & (up < width - least)
    up = np.maximum(up, least)
    second = (down > least) & (width - up - down > least)
    places = np.concatenate((lines[first] + 1, lines[second] + 1))
    at = np.concatenate((s[lines][first] + up[first], (s[lines + 1] - down)[second]))
    order = np.lexsort((at, places))
    places, at = places[order], at[order]
    value = np.concatenate((peak[first], peak[second]))[order]
    cell = np.concatenate((lines[first], lines[second]))[order]
    return (
        np.insert(piece, places, piece[cell]),
        np.insert(s, places, at),
        np.insert(squared, places, value),
    )


def _sampled(
    piece: NDArray[np.intp], s: Array, squared: Array, resample_s: float
) -> tuple[NDArray[np.intp], Array, Array, Array]:
    """Return piece, length, speed and time of every cell's end and every `resample_s` between."""
    speed = np.sqrt(squared)
    width = np.diff(s)
    time = np.concatenate(([0.0], np.cumsum(2 * width / (speed[:-1] + speed[1:]))))
    step = max(resample_s, float(time[-1]) / _MOST_POINTS)
    grid = np.arange(1, math.ceil(float(time[-1]) / step)) * step
    cell = np.minimum(np.searchsorted(time, grid, side="right") - 1, len(width) - 1)
    apart = (grid - time[cell] > 1e-4 * step) & (time[cell + 1] - grid > 1e-4 * step)
    grid, cell = grid[apart], cell[apart]
    u = (squared[cell + 1] - squared[cell]) / (2 * width[cell])
    since = grid - time[cell]
    between = s[cell] + since * (speed[cell] + u * since / 2)
    places = cell + 1
    time = np.insert(time, places, grid)
    # Messages have whole nanoseconds, in which no two points may be at one time.
    kept = np.append(True, np.diff(time) > _LEAST_S)
    if not kept[-1]:
        kept[np.flatnonzero(kept)[-1]] = False
        kept[[0, -1]] = True
    return (
        np.insert(np.append(piece, piece[-1]), places, piece[cell])[kept],
        np.insert(s, places, between)[kept],
        np.insert(speed, places, speed[cell] + u * since)[kept],
        time[kept],
    )
