"""What a node sees of actions, its own and others'."""

from __future__ import annotations

from typing import Any

from rclpy._run import run

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.robot.bring_up.system import SystemState

NamesAndTypes = list[tuple[str, list[str]]]


def get_action_names_and_types(node: Any) -> NamesAndTypes:
    """Return every action that has a client or a server, with its types."""
    run().scheduler.touch()
    system = current().client(SystemState)
    return _listed(dict.fromkeys(system.action_names_and_types()))


def get_action_client_names_and_types_by_node(
    node: Any, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions of which a node has a client, with their types.

    Raises:
        NodeNameNonExistentError: no such node is known.
    """
    return _of_node(run().actions.clients(), node, remote_node_name, remote_node_namespace)


def get_action_server_names_and_types_by_node(
    node: Any, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions that a node serves, with their types; see the last."""
    known = node._known(remote_node_name, remote_node_namespace)
    beside = current().client(SystemState).actions()
    of_node = _of_node(run().actions.servers(), node, remote_node_name, remote_node_namespace)
    served = {(name, kind): None for name, kind, server in beside if server == known}
    return sorted(dict((*_listed(served), *of_node)).items())


def _of_node(ends: Any, node: Any, name: str, namespace: str) -> NamesAndTypes:
    run().scheduler.touch()
    known = node._known(name, namespace)
    return _listed({(end.name, end.type_name): None for end in ends if end.node == known})


def _listed(pairs: dict[tuple[str, str], None]) -> NamesAndTypes:
    types_of: dict[str, list[str]] = {}
    for name, type_name in sorted(pairs):
        types_of.setdefault(name, []).append(type_name.replace("/", "/action/", 1))
    return list(types_of.items())
