"""Stand-in for rosservice: which services there are, and calls of them by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import rospy
from roslib.message import get_service_class as _class_of

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.robot.bring_up.system import SystemState


class ROSServiceException(Exception):
    """Something is wrong with a service."""


class ROSServiceIOException(ROSServiceException):
    """The master or the service does not answer."""


def get_service_list(
    node: str | None = None, namespace: str | None = None, include_nodes: bool = False
) -> list[Any]:
    """Return the names of the services, of one node or namespace; with the nodes if asked for."""
    begin = None if namespace is None else rospy.resolve_name(namespace).rstrip("/") + "/"
    servers = [
        server
        for server in current().client(SystemState).services()
        if (node is None or server.node == rospy.resolve_name(node))
        and (begin is None or server.topic.startswith(begin))
    ]
    if include_nodes:
        return [[server.topic, [server.node]] for server in servers]
    return [server.topic for server in servers]


def get_service_type(service_name: str) -> str | None:
    """Return the type of a service, or None if nobody serves it."""
    server = current().graph.services.find(rospy.resolve_name(service_name))
    return None if server is None else server.type_name


def get_service_node(service_name: str) -> str | None:
    """Return the node that serves a name, or None."""
    server = current().graph.services.find(rospy.resolve_name(service_name))
    return None if server is None else server.node


def get_service_class_by_name(service_name: str) -> Any:
    """Return the class of a service.

    Raises:
        ROSServiceException: nobody serves it, or its type is not known.
    """
    type_name = get_service_type(service_name)
    if type_name is None:
        raise ROSServiceException(f"Service [{service_name}] is not available.")
    kind = _class_of(type_name)
    if kind is None:
        raise ROSServiceException(f"Unable to load type [{type_name}].")
    return kind


def call_service(
    service_name: str, service_args: Sequence[Any], service_class: Any = None
) -> tuple[Any, Any]:
    """Call a service with the fields of its request; return request and response.

    Raises:
        ROSServiceException: nobody serves it, or the call fails.
    """
    kind = service_class or get_service_class_by_name(service_name)
    request = kind._request_class(*service_args)
    try:
        return request, rospy.ServiceProxy(service_name, kind)(request)
    except rospy.ServiceException as error:
        raise ROSServiceException(str(error)) from error


def rosservice_find(service_type: str) -> list[str]:
    """Return the services of a type."""
    servers = current().client(SystemState).services()
    return [server.topic for server in servers if server.type_name == service_type]


__all__ = _defined(globals())
