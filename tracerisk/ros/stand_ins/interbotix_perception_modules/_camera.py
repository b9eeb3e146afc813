"""What the interfaces of perception have in common in either ROS."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped

from tracerisk.ros.controller.needs import Need, asking_place
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.messages.dialect import is_ros2

IS_ROS2 = is_ros2(TransformStamped)


def is_served(service: str, type_name: str) -> bool:
    """Return whether somebody answers a service; one that nobody answers is a need of the run."""
    runtime = current()
    if runtime.graph.services.find(service) is not None:
        return True
    runtime.scheduler.miss(Need("service", service, type_name))
    return False


def report_unseen(what: str) -> None:
    """Report what a camera would have measured, and the run goes on without."""
    current().recorder.finding(
        "unprovided", f"{what} needs a camera, and tracerisk simulates none", asking_place()
    )


def begin(name: str, init_node: bool) -> None:
    """Initialise the node of ROS 1 where it is wanted."""
    if init_node:
        import rospy

        rospy.init_node(name.strip("/") + "_interface")


def node_of(given: Any) -> Any:
    """Return the node of ROS 2.

    Raises:
        NotImplementedError: none is given, as in the library.
    """
    if given is None:
        raise NotImplementedError("Passing node_inf as None is not implemented.")
    return given


def warn(node: Any, message: str) -> None:
    """Log a warning in the ROS of this run."""
    if node is not None:
        node.get_logger().warning(message)
    else:
        import rospy

        rospy.logwarn(message)
