"""Stand-in for rosnode: the nodes that publish, subscribe or serve, and those of a bring-up.

Programs wait for what a bring-up starts, the display included, before they move.
"""

from __future__ import annotations

import rospy

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.robot.bring_up.system import SystemState

__all__ = ["ROSNodeException", "ROSNodeIOException", "get_node_names", "rosnode_ping"]

_BRING_UP = ("/robot_state_publisher", "/rosout", "/rviz")


class ROSNodeException(Exception):
    """Something is wrong with a node."""


class ROSNodeIOException(ROSNodeException):
    """The master or a node does not answer."""


def get_node_names(namespace: str | None = None) -> list[str]:
    """Return the names of the nodes, those of a namespace if one is given, sorted."""
    names = {*_BRING_UP, *current().client(SystemState).nodes(), rospy.get_name()}
    if namespace is None:
        return sorted(names)
    begin = "/" + namespace.strip("/")
    return sorted(name for name in names if name == begin or name.startswith(f"{begin}/"))


def rosnode_ping(node_name: str, max_count: int | None = None, verbose: bool = False) -> bool:
    """Return whether a node answers."""
    return rospy.resolve_name(node_name) in get_node_names()
