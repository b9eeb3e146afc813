"""The topics of a server of markers, and its service, in either ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from visualization_msgs.msg import (
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerUpdate,
)

from tracerisk.ros.drafts.user_input.dragged_markers import ShownMarkers
from tracerisk.ros.graph.runtime import current

Heard = Callable[[Any], None]
"""Takes a message of feedback."""
Shown = Callable[[], list[Any]]
"""Returns the markers that are shown."""


class Ends(Protocol):
    """What a server sends."""

    name: str
    """The name of the server, by which viewers know it from others."""

    def update(self, message: Any) -> None:
        """Send what has changed."""

    def init(self, message: Any) -> None:
        """Send all that is shown."""


class Ends1:
    """In ROS 1: ros-visualization/interactive_markers, noetic-devel, src."""

    def __init__(self, heard: Heard, shown: Shown, topic_ns: str, q_size: int = 100) -> None:
        import rospy

        self.name = f"{rospy.get_name()}{rospy.resolve_name(topic_ns)}"
        self._init = rospy.Publisher(
            f"{topic_ns}/update_full", InteractiveMarkerInit, latch=True, queue_size=100
        )
        self._update = rospy.Publisher(
            f"{topic_ns}/update", InteractiveMarkerUpdate, queue_size=100
        )
        self._feedback = rospy.Subscriber(
            f"{topic_ns}/feedback", InteractiveMarkerFeedback, heard, queue_size=q_size
        )
        current().client(ShownMarkers).add(self._feedback.resolved_name, shown)

    def update(self, message: Any) -> None:
        """Send what has changed."""
        self._update.publish(message)

    def init(self, message: Any) -> None:
        """Send all that is shown."""
        self._init.publish(message)


class Ends2:
    """In ROS 2, where new viewers ask a service: ros-visualization/interactive_markers, humble."""

    def __init__(
        self,
        heard: Heard,
        shown: Shown,
        node: Any,
        namespace: str,
        q_size: int = 100,
        *,
        update_pub_qos: Any = 100,
        feedback_sub_qos: Any = 1,
    ) -> None:
        from visualization_msgs.srv import GetInteractiveMarkers

        del q_size
        self.name = f"{node.get_name()}/{namespace}"
        self._update = node.create_publisher(
            InteractiveMarkerUpdate, f"{namespace}/update", update_pub_qos
        )
        self._feedback = node.create_subscription(
            InteractiveMarkerFeedback, f"{namespace}/feedback", heard, feedback_sub_qos
        )
        current().client(ShownMarkers).add(self._feedback.topic_name, shown)

        def answer(_: Any, response: Any) -> Any:
            response.markers.extend(shown())
            return response

        self._service = node.create_service(
            GetInteractiveMarkers, f"{namespace}/get_interactive_markers", answer
        )

    def update(self, message: Any) -> None:
        """Send what has changed."""
        self._update.publish(message)

    def init(self, message: Any) -> None:
        """Send nothing: viewers ask the service."""
