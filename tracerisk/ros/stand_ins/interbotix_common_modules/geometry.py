"""Whether quaternions are valid; the older home of `angle_manipulation.quaternion_is_valid`."""

from .angle_manipulation import quaternion_is_valid

__all__ = ["quaternion_is_valid"]
