"""Turns and poses as matrices; the names of ROS 1 and of ROS 2."""

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

__all__ = [
    "eulerAnglesToRotationMatrix",
    "euler_angles_to_quaternion",
    "euler_angles_to_rotation_matrix",
    "poseToTransformationMatrix",
    "pose_to_transformation_matrix",
    "quaternion_is_valid",
    "rotationMatrixToEulerAngles",
    "rotation_matrix_to_euler_angles",
    "transInv",
    "trans_inv",
    "yawToRotationMatrix",
    "yaw_to_rotation_matrix",
]
