"""Bodies that the controller put into the scene while it ran, as the replay shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tracerisk.report.html.run.replay_model import FREE_COLUMNS, Body
from tracerisk.twin.physics.declared_log import DeclaredChange, LoggedShape, Points

Array = NDArray[np.float64]

MOST_BODIES = 300
_PLANE = 1.5  # half the side of the square that is shown of a plane [m]


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredBodies:
    """Bodies that the controller put into the scene."""

    bodies: tuple[Body, ...]
    """Bodies with the time in which each is there, at most `MOST_BODIES`."""
    values: Array
    """Poses of those that can move, (n_frames, 7 n_free); before and after its time a body is
    where it was at the ends [m; quaternion]."""
    left_out: int
    """Number of bodies beyond `MOST_BODIES`."""


def declared_bodies(
    changes: Sequence[DeclaredChange],
    *,
    first_column: int,
    n_frames: int,
    steps_per_frame: int,
    step_s: float,
) -> DeclaredBodies:
    """Return the declared bodies of a run; columns begin with `first_column`.

    A body that stays what it was over several changes is one.
    """
    spans: list[tuple[LoggedShape, int, int | None]] = []
    live: dict[LoggedShape, int] = {}
    moves: dict[tuple[str, int], list[tuple[float, Array]]] = {}
    for change in changes:
        keys = {_lasting(body): body for body in change.bodies}
        for key in [key for key in live if key not in keys]:
            spans[live[key]] = (*spans[live[key]][:2], change.step)
            del live[key]
        for key, body in keys.items():
            if key not in live:
                live[key] = len(spans)
                spans.append((body, change.step, None))
        free = [body for body in change.bodies if body.is_free]
        for index, body in enumerate(free):
            place = live[_lasting(body)]
            moved = moves.setdefault((body.name, place), [(change.step, np.array(body.pose))])
            moved += zip(change.pose_steps.tolist(), change.poses[:, index], strict=True)
    bodies: list[Body] = []
    columns: list[Array] = []
    for place, (shown, since, until) in enumerate(spans[:MOST_BODIES]):
        there = Body(
            name=shown.name,
            kind="declared",
            parent=-1,
            xyz=(shown.pose[0], shown.pose[1], shown.pose[2]),
            quaternion=(shown.pose[3], shown.pose[4], shown.pose[5], shown.pose[6]),
            shapes=shown.shapes,
            triangles=tuple(_triangles(shown)),
            since_s=since * step_s,
            until_s=None if until is None else until * step_s,
        )
        if shown.is_free:
            column = first_column + FREE_COLUMNS * len(columns)
            there = replace(there, joint="free", column=column)
            columns.append(_column(moves[shown.name, place], n_frames, steps_per_frame))
        bodies.append(there)
    values = np.hstack(columns) if columns else np.zeros((n_frames, 0))
    return DeclaredBodies(tuple(bodies), values, max(len(spans) - MOST_BODIES, 0))


def _lasting(body: LoggedShape) -> LoggedShape:
    """Return what of a body says that it is the same: of one that moves, not where it is."""
    return replace(body, pose=()) if body.is_free else body


def _column(moves: Sequence[tuple[float, Array]], n_frames: int, steps_per_frame: int) -> Array:
    """Return the pose at each frame, (n_frames, 7): the last one that was logged before it."""
    steps = np.array([step for step, _ in moves])
    poses = np.array([pose for _, pose in moves])
    last = np.searchsorted(steps, np.arange(n_frames) * steps_per_frame, side="right") - 1
    return np.asarray(poses[np.maximum(last, 0)])


def _triangles(body: LoggedShape) -> list[float]:
    triangles: list[float] = []
    for hull in body.hulls:
        triangles += _hull_triangles(hull)
    for plane in body.planes:
        triangles += _square(plane)
    return triangles


def _hull_triangles(points: Points) -> list[float]:
    """Return the triangles of a convex hull, each counter-clockwise from outside."""
    # Imported here, for few runs have a mesh.
    from scipy.spatial import ConvexHull

    hull = ConvexHull(np.array(points))
    hull_triangles: list[float] = []
    for corners, equation in zip(hull.simplices, hull.equations, strict=True):
        one, two, three = hull.points[corners]
        if np.cross(two - one, three - one) @ equation[:3] < 0.0:
            two, three = three, two
        hull_triangles += [*one.tolist(), *two.tolist(), *three.tolist()]
    return hull_triangles


def _square(plane: Sequence[float]) -> list[float]:
    """Return two triangles of a plane, given by position and quaternion (w, x, y, z)."""
    w, x, y, z = plane[3:]
    along = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    across = np.array([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)])
    middle = np.array(plane[:3])
    corners = [
        (middle + _PLANE * (a * along + b * across)).tolist()
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return [value for index in (0, 1, 2, 0, 2, 3) for value in corners[index]]
