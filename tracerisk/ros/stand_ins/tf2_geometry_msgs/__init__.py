# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for tf2_geometry_msgs: importing it lets buffers transform messages of geometry_msgs."""

from geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped, WrenchStamped

from tracerisk.ros.imports.exported import exported as _exported

from .tf2_geometry_msgs import (
    do_transform_point,
    do_transform_polygon_stamped,
    do_transform_pose,
    do_transform_pose_stamped,
    do_transform_pose_with_covariance_stamped,
    do_transform_vector3,
    do_transform_wrench,
    from_msg_msg,
    to_msg_msg,
    transform_covariance,
    transform_to_kdl,
)

__all__ = _exported(globals())
