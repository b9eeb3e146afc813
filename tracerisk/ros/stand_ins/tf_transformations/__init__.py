"""Stand-in for tf_transformations: `tf.transformations` for ROS 2.

Where the real library reorders what transforms3d returns, results are tuples.
"""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from tracerisk.ros.homogeneous import turns
from tracerisk.ros.homogeneous.arcball import (
    Arcball,
    arcball_constrain_to_axis,
    arcball_map_to_sphere,
    arcball_nearest_axis,
)
from tracerisk.ros.homogeneous.matrices import (
    clip_matrix,
    identity_matrix,
    projection_from_matrix,
    projection_matrix,
    reflection_from_matrix,
    reflection_matrix,
    rotation_from_matrix,
    rotation_matrix,
    scale_from_matrix,
    scale_matrix,
    shear_from_matrix,
    shear_matrix,
    translation_from_matrix,
    translation_matrix,
)
from tracerisk.ros.homogeneous.parts import (
    compose_matrix,
    concatenate_matrices,
    decompose_matrix,
    inverse_matrix,
    is_same_transform,
    orthogonalization_matrix,
    superimposition_matrix,
)
from tracerisk.ros.homogeneous.turns import (
    euler_from_matrix,
    euler_from_quaternion,
    euler_matrix,
    quaternion_conjugate,
    quaternion_inverse,
    quaternion_matrix,
    quaternion_slerp,
    random_quaternion,
    random_rotation_matrix,
)
from tracerisk.ros.homogeneous.vectors import (
    Array,
    random_vector,
    unit_vector,
    vector_norm,
)

__all__ = [
    "Arcball",
    "arcball_constrain_to_axis",
    "arcball_map_to_sphere",
    "arcball_nearest_axis",
    "clip_matrix",
    "compose_matrix",
    "concatenate_matrices",
    "decompose_matrix",
    "euler_from_matrix",
    "euler_from_quaternion",
    "euler_matrix",
    "identity_matrix",
    "inverse_matrix",
    "is_same_transform",
    "orthogonalization_matrix",
    "projection_from_matrix",
    "projection_matrix",
    "quaternion_about_axis",
    "quaternion_conjugate",
    "quaternion_from_euler",
    "quaternion_from_matrix",
    "quaternion_inverse",
    "quaternion_matrix",
    "quaternion_multiply",
    "quaternion_slerp",
    "random_quaternion",
    "random_rotation_matrix",
    "random_vector",
    "reflection_from_matrix",
    "reflection_matrix",
    "rotation_from_matrix",
    "rotation_matrix",
    "scale_from_matrix",
    "scale_matrix",
    "shear_from_matrix",
    "shear_matrix",
    "superimposition_matrix",
    "translation_from_matrix",
    "translation_matrix",
    "unit_vector",
    "vector_norm",
]

Quaternion = tuple[float, float, float, float]


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: turns.Axes = "sxyz") -> Quaternion:
    """Return the quaternion of three Euler angles [rad]."""
    return _tuple(turns.quaternion_from_euler(ai, aj, ak, axes))


def quaternion_about_axis(angle: float, axis: ArrayLike) -> Quaternion:
    """Return the turn by an angle [rad] about an axis."""
    return _tuple(turns.quaternion_about_axis(angle, axis))


def quaternion_from_matrix(matrix: ArrayLike) -> Quaternion:
    """Return the quaternion of a rotation (4, 4), whose w is not negative."""
    turn = turns.quaternion_from_matrix(matrix)
    return _tuple(-turn if turn[3] < 0.0 else turn)


def quaternion_multiply(quaternion1: Sequence[float], quaternion0: Sequence[float]) -> Quaternion:
    """Return the turn `quaternion0` followed by `quaternion1`."""
    return _tuple(turns.quaternion_multiply(quaternion1, quaternion0))


def _tuple(values: Array) -> Quaternion:
    x, y, z, w = values.tolist()
    return (x, y, z, w)
