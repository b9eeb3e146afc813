"""Publishes transforms on `/tf`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import tf2_ros
from geometry_msgs.msg import TransformStamped


class TransformBroadcaster:
    """Publish where frames are."""

    def __init__(self, queue_size: int = 100) -> None:
        self.tf2_broadcaster = tf2_ros.TransformBroadcaster()

    def sendTransform(
        self,
        translation: Sequence[float],
        rotation: Sequence[float],
        time: Any,
        child: str,
        parent: str,
    ) -> None:
        """Send where `child` is in `parent`: a vector [m] and a quaternion (x, y, z, w)."""
        message = TransformStamped()
        message.header.frame_id = parent
        message.header.stamp = time
        message.child_frame_id = child
        shift, turn = message.transform.translation, message.transform.rotation
        shift.x, shift.y, shift.z = translation[0], translation[1], translation[2]
        turn.x, turn.y, turn.z, turn.w = rotation[0], rotation[1], rotation[2], rotation[3]
        self.sendTransformMessage(message)

    def sendTransformMessage(self, transform: Any) -> None:
        """Send a TransformStamped."""
        self.tf2_broadcaster.sendTransform([transform])
