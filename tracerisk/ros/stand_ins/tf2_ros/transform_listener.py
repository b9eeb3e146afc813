"""Fills a buffer with what is published on `/tf` and `/tf_static`."""

from __future__ import annotations

from functools import partial
from threading import Lock, Thread
from typing import Any

from tf2_msgs.msg import TFMessage

from ._dialect import IS_ROS2

__all__ = ["TransformListener"]

DEFAULT_TF_TOPIC = "/tf"
DEFAULT_STATIC_TF_TOPIC = "/tf_static"


class _Listener:
    """What both have in common: the messages go into the buffer."""

    buffer: Any

    def callback(self, data: Any) -> None:
        """Take a message of `/tf`."""
        who = self._authority(data)
        for transform in data.transforms:
            self.buffer.set_transform(transform, who)

    def static_callback(self, data: Any) -> None:
        """Take a message of `/tf_static`."""
        who = self._authority(data)
        for transform in data.transforms:
            self.buffer.set_transform_static(transform, who)

    def _authority(self, data: Any) -> str:
        header = getattr(data, "_connection_header", None) or {}
        return str(header.get("callerid", "default_authority"))


class _Ros1Listener(_Listener):
    """Listen on threads of its own, as every subscriber of ROS 1."""

    def __init__(
        self,
        buffer: Any,
        queue_size: int | None = None,
        buff_size: int = 65536,
        tcp_nodelay: bool = False,
    ) -> None:
        import rospy

        self.buffer = buffer
        self.last_update = rospy.Time.now()
        self.last_update_lock = Lock()
        options = {"queue_size": queue_size, "buff_size": buff_size, "tcp_nodelay": tcp_nodelay}
        self.tf_sub = rospy.Subscriber(DEFAULT_TF_TOPIC, TFMessage, self.callback, **options)
        self.tf_static_sub = rospy.Subscriber(
            DEFAULT_STATIC_TF_TOPIC, TFMessage, self.static_callback, **options
        )

    def unregister(self) -> None:
        """Stop listening."""
        self.tf_sub.unregister()
        self.tf_static_sub.unregister()

    def check_for_reset(self) -> None:
        """Do nothing: simulated time never jumps back."""


class _Ros2Listener(_Listener):
    """Listen while something spins `node`, or on a thread of its own with `spin_thread`."""

    def __init__(
        self,
        buffer: Any,
        node: Any,
        *,
        spin_thread: bool = False,
        qos: Any = None,
        static_qos: Any = None,
        tf_topic: str = DEFAULT_TF_TOPIC,
        tf_static_topic: str = DEFAULT_STATIC_TF_TOPIC,
    ) -> None:
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile

        profile = partial(QoSProfile, depth=100, history=HistoryPolicy.KEEP_LAST)
        if qos is None:
            qos = profile(durability=DurabilityPolicy.VOLATILE)
        if static_qos is None:
            static_qos = profile(durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.buffer = buffer
        self.node = node
        # A callback that waits for a transform must not keep the listener's from running.
        self.group = ReentrantCallbackGroup()
        self.tf_sub = node.create_subscription(
            TFMessage, tf_topic, self.callback, qos, callback_group=self.group
        )
        self.tf_static_sub = node.create_subscription(
            TFMessage, tf_static_topic, self.static_callback, static_qos, callback_group=self.group
        )
        if spin_thread:
            self._spin()

    def _spin(self) -> None:
        from rclpy.executors import SingleThreadedExecutor

        self.executor = SingleThreadedExecutor()

        def spin() -> None:
            self.executor.add_node(self.node)
            self.executor.spin()
            self.executor.remove_node(self.node)

        # The real thread is not a daemon; it ends when the context shuts down.
        self.dedicated_listener_thread = Thread(target=spin, daemon=True)
        self.dedicated_listener_thread.start()

    def unregister(self) -> None:
        """Stop listening."""
        self.node.destroy_subscription(self.tf_sub)
        self.node.destroy_subscription(self.tf_static_sub)


_Base: Any = _Ros2Listener if IS_ROS2 else _Ros1Listener


class TransformListener(_Base):  # type: ignore[misc]
    """Keep a buffer up to date."""
