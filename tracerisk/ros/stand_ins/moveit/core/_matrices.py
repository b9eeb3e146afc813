"""Transforms and Jacobians as arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tracerisk.ros.transforms.poses import Vector, compose, inverse, rotate
from tracerisk.twin.physics.motion import Pose

Array = NDArray[np.float64]


def matrix(pose: Pose) -> Array:
    """Return a pose as a transform, (4, 4)."""
    made = np.eye(4)
    for column, axis in enumerate(np.eye(3)):
        made[:3, column] = rotate(pose.orientation, tuple(axis))
    made[:3, 3] = pose.position
    return made


def jacobian(
    chain: Sequence[tuple[int, str, Vector, bool]],
    n_joints: int,
    pose_of: Callable[[str], Pose],
    root: str,
    link: str,
    point: Sequence[float],
    *,
    quaternions: bool = False,
) -> Array:
    """Return the Jacobian of a point of `link` in the frame of `root`.

    A column is (axis x arm, axis) for a joint that turns, (axis, 0) for one that slides
    (Siciliano et al., Robotics, 2009, section 3.1.3).
    chain: column, child link, axis in that link, and whether it slides, of each joint.
    point: (3,) in the link's frame [m].
    """
    back = inverse(pose_of(root))
    tip = compose(back, pose_of(link))
    x, y, z = (float(value) for value in np.asarray(point, dtype=np.float64).reshape(-1))
    at = np.array(compose(tip, Pose((x, y, z), (0.0, 0.0, 0.0, 1.0))).position)
    made = np.zeros((6, n_joints))
    for column, child, axis, slides in chain:
        joint = compose(back, pose_of(child))
        along = np.array(rotate(joint.orientation, axis))
        if slides:
            made[:3, column] = along
        else:
            made[:3, column] = np.cross(along, at - np.array(joint.position))
            made[3:, column] = along
    if not quaternions:
        return made
    # The rate of a unit quaternion under a turning rate (Diebel, Representing Attitude, 2006).
    qx, qy, qz, qw = tip.orientation
    rates = np.array([[-qx, -qy, -qz], [qw, qz, -qy], [-qz, qw, qx], [qy, -qx, qw]])
    return np.vstack((made[:3], 0.5 * rates @ made[3:]))
