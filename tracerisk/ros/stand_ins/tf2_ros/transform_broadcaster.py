"""Publishes transforms that change."""

from __future__ import annotations

from typing import Any

from tf2_msgs.msg import TFMessage

from ._dialect import IS_ROS2

__all__ = ["TransformBroadcaster"]


class _Ros1Broadcaster:
    """Publish on `/tf`."""

    def __init__(self) -> None:
        import rospy

        self.pub_tf = rospy.Publisher("/tf", TFMessage, queue_size=100)


class _Ros2Broadcaster:
    """Publish on `/tf` as `node`; `qos` is a profile or a depth."""

    def __init__(self, node: Any, qos: Any = None) -> None:
        from rclpy.qos import QoSProfile

        self.pub_tf = node.create_publisher(
            TFMessage, "/tf", QoSProfile(depth=100) if qos is None else qos
        )


_Base: Any = _Ros2Broadcaster if IS_ROS2 else _Ros1Broadcaster


class TransformBroadcaster(_Base):  # type: ignore[misc]
    """Publish where frames are."""

    def sendTransform(self, transform: Any) -> None:
        """Send a TransformStamped or a list of them."""
        self.pub_tf.publish(TFMessage(transforms=as_list(transform)))


def as_list(transforms: Any) -> list[Any]:
    """Return one or several transforms as a list."""
    return list(transforms) if isinstance(transforms, list | tuple) else [transforms]
