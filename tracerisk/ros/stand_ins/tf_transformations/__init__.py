"""Stand-in for tf_transformations: `tf.transformations` for ROS 2.

Where the real library reorders what transforms3d returns, results are tuples.
"""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from tracerisk.ros import homogeneous as _homogeneous
from tracerisk.ros.homogeneous import *  # noqa: F403 - each name of it, as the real library has
from tracerisk.ros.homogeneous import turns
from tracerisk.ros.homogeneous.vectors import Array
from tracerisk.ros.readings.euler_angles import look_at_euler as _look_at_euler

__all__ = list(_homogeneous.__all__)

Quaternion = tuple[float, float, float, float]


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: turns.Axes = "sxyz") -> Quaternion:  # type: ignore[no-redef]
    """Return the quaternion of three Euler angles [rad]."""
    _look_at_euler((ai, aj, ak), "quaternion_from_euler")
    return _tuple(turns.quaternion_from_euler(ai, aj, ak, axes))


def quaternion_about_axis(angle: float, axis: ArrayLike) -> Quaternion:  # type: ignore[no-redef]
    """Return the turn by an angle [rad] about an axis."""
    return _tuple(turns.quaternion_about_axis(angle, axis))


def quaternion_from_matrix(matrix: ArrayLike) -> Quaternion:  # type: ignore[no-redef]
    """Return the quaternion of a rotation (4, 4), whose w is not negative."""
    turn = turns.quaternion_from_matrix(matrix)
    return _tuple(-turn if turn[3] < 0.0 else turn)


def quaternion_multiply(quaternion1: Sequence[float], quaternion0: Sequence[float]) -> Quaternion:  # type: ignore[no-redef]
    """Return the turn `quaternion0` followed by `quaternion1`."""
    return _tuple(turns.quaternion_multiply(quaternion1, quaternion0))


def _tuple(values: Array) -> Quaternion:
    x, y, z, w = values.tolist()
    return (x, y, z, w)
