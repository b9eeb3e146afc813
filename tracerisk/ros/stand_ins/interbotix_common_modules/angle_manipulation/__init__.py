# ruff: noqa: F401 - what is imported here is what the module gives
"""Turns and poses as matrices; the names of ROS 1 and of ROS 2."""

from tracerisk.ros.imports.exported import exported as _exported

from .angle_manipulation import (
    euler_angles_to_quaternion,
    euler_angles_to_rotation_matrix,
    eulerAnglesToRotationMatrix,
    pose_to_transformation_matrix,
    poseToTransformationMatrix,
    quaternion_is_valid,
    rotation_matrix_to_euler_angles,
    rotationMatrixToEulerAngles,
    trans_inv,
    transInv,
    yaw_to_rotation_matrix,
    yawToRotationMatrix,
)

__all__ = _exported(globals())
