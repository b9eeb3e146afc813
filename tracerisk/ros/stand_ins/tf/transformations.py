"""Matrices (4, 4), quaternions (x, y, z, w) and Euler angles."""

from tracerisk.ros import homogeneous as _homogeneous
from tracerisk.ros.homogeneous import *  # noqa: F403 - each name of it, as the real library has
from tracerisk.ros.homogeneous import turns as _turns
from tracerisk.ros.homogeneous.vectors import Array as _Array
from tracerisk.ros.readings.euler_angles import look_at_euler as _look_at_euler

__all__ = list(_homogeneous.__all__)


def quaternion_from_euler(  # type: ignore[no-redef]
    ai: float, aj: float, ak: float, axes: _turns.Axes = "sxyz"
) -> _Array:
    """Return the quaternion of three Euler angles [rad]: (4,).

    Raises:
        KeyError: there is no such kind of angles.
    """
    _look_at_euler((ai, aj, ak), "quaternion_from_euler")
    return _turns.quaternion_from_euler(ai, aj, ak, axes)


def euler_matrix(  # type: ignore[no-redef]
    ai: float, aj: float, ak: float, axes: _turns.Axes = "sxyz"
) -> _Array:
    """Return the rotation of three Euler angles [rad]: (4, 4).

    Raises:
        KeyError: there is no such kind of angles.
    """
    _look_at_euler((ai, aj, ak), "euler_matrix")
    return _turns.euler_matrix(ai, aj, ak, axes)
