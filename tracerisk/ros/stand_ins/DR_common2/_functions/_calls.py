"""Calls of the controller's services, by rospy or by rclpy."""

from __future__ import annotations

from functools import cache
from typing import Any

import DR_init
from std_msgs.msg import Float64MultiArray

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.messages.dialect import is_ros2

_IS_ROS2 = is_ros2(Float64MultiArray)

if _IS_ROS2:
    import rclpy
    from dsr_msgs2 import srv

    # As in the library: without a node it cannot be imported.
    g_node: Any = DR_init.__dsr__node
else:
    import rospy
    from dsr_msgs import srv

    g_node = None


def call(kind: str, service: str, fields: dict[str, Any]) -> Any:
    """Call a service of a kind with fields by their names of ROS 2; return its response."""
    if not _IS_ROS2:
        request = getattr(srv, f"{kind}Request")()
        for field, value in fields.items():
            setattr(request, field if hasattr(request, field) else _of_ros1(field), value)
        # Pins of the controller's box have names without it in ROS 1.
        return _proxy(kind, service.replace("ctrl_box_", ""))(request)
    request = getattr(srv, kind).Request()
    for field, value in fields.items():
        setattr(request, field, value)
    future = _client(kind, service).call_async(request)
    rclpy.spin_until_future_complete(g_node, future)
    return future.result()


def _of_ros1(field: str) -> str:
    """Return a field's name as most are written in ROS 1: `syncType` for `sync_type`."""
    first, *rest = field.split("_")
    return first + "".join(part.capitalize() for part in rest)


@cache
def _proxy(kind: str, name: str) -> Any:
    space = f"/{DR_init.__dsr__id}{DR_init.__dsr__model}"
    return rospy.ServiceProxy(f"{space}/{name}", getattr(srv, kind))


@cache
def _client(kind: str, name: str) -> Any:
    client = g_node.create_client(getattr(srv, kind), name)
    # The library makes all its clients, some two hundred, when it is imported, which takes longer.
    current().graph.carrier.pass_connections()
    return client
