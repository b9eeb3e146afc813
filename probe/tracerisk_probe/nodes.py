"""The node through which commands are published: the controller's in ROS 1, an own one in ROS 2."""

from __future__ import annotations

import os
import sys
from typing import Any

from tracerisk_probe.writing import TOPIC, Topic

_DEPTH = 10_000


class Finding:
    """Looks for a node of ROS until there is one, and opens the topic on it."""

    def __init__(self, topic: Topic) -> None:
        self._topic = topic
        self._is_done = False

    def __call__(self) -> None:
        """Open the topic if a node is up."""
        if self._is_done:
            return
        try:
            self._is_done = self._opened_ros1() or self._opened_ros2()
        except Exception as error:  # noqa: BLE001 -- no failure of ours may end a controller
            self._is_done = True
            sys.stderr.write(
                f"tracerisk-probe: nothing is published: {type(error).__name__}: {error}\n"
            )

    def _opened_ros1(self) -> bool:
        rospy = sys.modules.get("rospy")
        if rospy is None or not _is_up(getattr(rospy, "core", None), "is_initialized"):
            return False
        from std_msgs.msg import String

        publisher = rospy.Publisher(TOPIC, String, queue_size=_DEPTH)
        self._topic.open(
            lambda text: publisher.publish(String(text)),
            lambda: bool(publisher.get_num_connections()),
        )
        return True

    def _opened_ros2(self) -> bool:
        rclpy = sys.modules.get("rclpy")
        if rclpy is None or not _is_up(rclpy, "ok"):
            return False
        from rclpy.qos import QoSDurabilityPolicy, QoSProfile
        from std_msgs.msg import String

        # Who subscribes late gets what was published before.
        kept = QoSProfile(depth=_DEPTH, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        node = rclpy.create_node(f"tracerisk_probe_{os.getpid()}")
        publisher = node.create_publisher(String, TOPIC, kept)
        self._topic.open(
            lambda text: publisher.publish(String(data=text)),
            lambda: bool(publisher.get_subscription_count()),
        )
        return True


def _is_up(module: Any | None, ask: str) -> bool:
    asked = getattr(module, ask, None)
    return bool(asked is not None and asked())
