"""Publishes transforms that never change."""

from __future__ import annotations

from typing import Any

from tf2_msgs.msg import TFMessage

from ._dialect import IS_ROS2
from .transform_broadcaster import as_list

__all__ = ["StaticTransformBroadcaster"]


class _Ros1StaticBroadcaster:
    """Publish on `/tf_static`; listeners that come later get what was sent last."""

    def __init__(self) -> None:
        import rospy

        self.pub_tf = rospy.Publisher("/tf_static", TFMessage, queue_size=100, latch=True)

    def sendTransform(self, transform: Any) -> None:
        """Send a TransformStamped or a list of them."""
        self.pub_tf.publish(TFMessage(transforms=as_list(transform)))


class _Ros2StaticBroadcaster:
    """Publish on `/tf_static` as `node`; listeners that come later get all that was sent."""

    def __init__(self, node: Any, qos: Any = None) -> None:
        from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile

        if qos is None:
            qos = QoSProfile(
                depth=1,
                durability=DurabilityPolicy.TRANSIENT_LOCAL,
                history=HistoryPolicy.KEEP_LAST,
            )
        self.pub_tf = node.create_publisher(TFMessage, "/tf_static", qos)
        self.net_message = TFMessage()
        self._child_frame_ids: set[str] = set()

    def sendTransform(self, transform: Any) -> None:
        """Send a TransformStamped or a list of them; of a frame, the first counts."""
        transforms = list(self.net_message.transforms)
        for item in as_list(transform):
            if item.child_frame_id not in self._child_frame_ids:
                self._child_frame_ids.add(item.child_frame_id)
                transforms.append(item)
        self.net_message.transforms = transforms
        self.pub_tf.publish(self.net_message)


_Base: Any = _Ros2StaticBroadcaster if IS_ROS2 else _Ros1StaticBroadcaster


class StaticTransformBroadcaster(_Base):  # type: ignore[misc]
    """Publish where frames are that never move."""
