"""What a node sees of the graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.robot.bring_up.assumed_listeners import AssumedListeners
from tracerisk.ros.robot.bring_up.system import SystemState

from ._node_entities import OF_ACTION
from ._node_names import NodeNames
from ._rclpy_pybind11 import NodeNameNonExistentError
from ._run import run
from .expand_topic_name import expand_topic_name
from .qos import QoSProfile
from .topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum

_TOPICS_OF_ACTION = {
    "feedback": "{package}/action/{name}_FeedbackMessage",
    "status": "action_msgs/msg/GoalStatusArray",
}
"""The topics below `NAME/_action` of each action, and their types."""
_SERVICES_OF_ACTION = {
    "send_goal": "{package}/action/{name}_SendGoal",
    "cancel_goal": "action_msgs/srv/CancelGoal",
    "get_result": "{package}/action/{name}_GetResult",
}
"""The services there, and their types."""


class NodeGraph(NodeNames):
    """What a node sees of topics, services and other nodes; a part of `Node`."""

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return each topic with its types: `std_msgs/msg/String`."""
        self._check_usable("failed to get topic names and types")
        system = _system()
        run().scheduler.touch()
        ends = {
            name: (*system.publications(name), *system.subscriptions(name))
            for name in system.topic_names()
        }
        types_of = {
            name: sorted({_full_type(end.type_name, "msg") for end in ends_of_topic})
            for name, ends_of_topic in ends.items()
        }
        return sorted((_of_actions(_TOPICS_OF_ACTION) | types_of).items())

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each service with its types: `std_srvs/srv/Trigger`."""
        self._check_usable("failed to get service names and types")
        run().scheduler.touch()
        types_of = {
            server.topic: [_full_type(server.type_name, "srv")] for server in _system().services()
        }
        return sorted((_of_actions(_SERVICES_OF_ACTION) | types_of).items())

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes, the controller's first."""
        return [name for name, _ in self.get_node_names_and_namespaces()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return names and namespaces of all nodes, the controller's first."""
        self._check_usable("Failed to get node names")
        run().scheduler.touch()
        return [_split(name) for name in _node_names()]

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publish on a topic."""
        self._check_usable("Error in rcl_count_publishers")
        run().scheduler.touch()
        return len(_system().publications(self._checked_topic(topic_name)))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscribe to a topic."""
        self._check_usable("Error in rcl_count_subscribers")
        run().scheduler.touch()
        name = self._checked_topic(topic_name)
        for publication in run().graph.publications(name):
            if publication.by_controller:
                current().client(AssumedListeners).count(publication)
        return len(_system().subscriptions(name))

    def count_clients(self, service_name: str) -> int:
        """Return how many of the controller's clients call a service."""
        self._check_usable("Error in rcl_count_clients")
        name = self._checked_service(service_name)
        return sum(client._full_name == name for node in run().nodes for client in node.clients)

    def count_services(self, service_name: str) -> int:
        """Return how many serve a service."""
        self._check_usable("Error in rcl_count_services")
        run().scheduler.touch()
        name = self._checked_service(service_name)
        return sum(server.topic == name for server in _system().services())

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return the full names of all nodes, the controller's first."""
        return _node_names()

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Return names, namespaces and enclaves of all nodes, the controller's first."""
        return [(*_split(name), "/") for name in _node_names()]

    def wait_for_node(self, fully_qualified_node_name: str, timeout: float) -> bool:
        """Wait `timeout` seconds until a node is there, and return whether it is."""
        name = "/" + fully_qualified_node_name.removeprefix("/")
        return run().scheduler.wait_until(
            lambda: name in self.get_fully_qualified_node_names(),
            timeout_ns=max(0, round(timeout * 1e9)),
            reason=f"node {name}",
            kind="unmet",
        )

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]:
        """Return the topics on which a node publishes, with their types.

        Raises:
            NodeNameNonExistentError: no such node is known.
        """
        return _topics_of(self._known(node_name, node_namespace), _system().publications)

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]:
        """Return the topics to which a node subscribes, with their types; see the last."""
        return _topics_of(self._known(node_name, node_namespace), _system().subscriptions)

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> list[tuple[str, list[str]]]:
        """Return the services of a node with their types; see the last but one."""
        name = self._known(node_name, node_namespace)
        return [
            (server.topic, [_full_type(server.type_name, "srv")])
            for server in _system().services()
            if server.node == name
        ]

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> list[tuple[str, list[str]]]:
        """Return the services that a node of the controller calls, with their types."""
        name = self._known(node_name, node_namespace)
        types_of = {
            client._full_name: _full_type(client.srv_type._ros_type, "srv")
            for node in run().nodes
            if node.get_fully_qualified_name() == name
            for client in node.clients
        }
        return [(service, [type_name]) for service, type_name in sorted(types_of.items())]

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return who publishes on a topic."""
        return self._endpoints(topic_name, TopicEndpointTypeEnum.PUBLISHER)

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return who subscribes to a topic."""
        return self._endpoints(topic_name, TopicEndpointTypeEnum.SUBSCRIPTION)

    def _checked_topic(self, name: str) -> str:
        expand_topic_name(name, self._name, self._namespace)
        return self.resolve_topic_name(name)

    def _checked_service(self, name: str) -> str:
        expand_topic_name(name, self._name, self._namespace)
        return self.resolve_service_name(name)

    def _endpoints(self, topic: str, kind: TopicEndpointTypeEnum) -> list[TopicEndpointInfo]:
        run().scheduler.touch()
        system, name = _system(), self._checked_topic(topic)
        publishes = kind is TopicEndpointTypeEnum.PUBLISHER
        ends: Any = system.publications(name) if publishes else system.subscriptions(name)
        endpoints = []
        for end in ends:
            handler = getattr(end, "on_connect" if publishes else "deliver", None)
            profile = getattr(getattr(handler, "__self__", None), "qos_profile", None)
            short, space = _split(end.node)
            endpoints.append(
                TopicEndpointInfo(
                    short,
                    space,
                    _full_type(end.type_name, "msg"),
                    kind,
                    qos_profile=QoSProfile(depth=10) if profile is None else profile,
                )
            )
        return endpoints

    def _known(self, node_name: str, node_namespace: str) -> str:
        name = f"{node_namespace.rstrip('/')}/{node_name}"
        if name not in self.get_fully_qualified_node_names():
            raise NodeNameNonExistentError(
                f"Cannot get topic names and types for nonexistent node '{name}'"
            )
        return name


def _living() -> list[Any]:
    """Return the controller's nodes that others see: not those of a context that was shut down."""
    return [node for node in run().nodes if node.context.is_valid]


def _system() -> SystemState:
    return current().client(SystemState)


def _node_names() -> list[str]:
    own = [node.get_fully_qualified_name() for node in _living()]
    shut_down = {node.get_fully_qualified_name() for node in run().nodes}
    return [*own, *(name for name in _system().nodes() if name not in shut_down)]


def _split(name: str) -> tuple[str, str]:
    space, _, short = name.rpartition("/")
    return short, space or "/"


def _topics_of(node: str, ends_of: Callable[[str], Any]) -> list[tuple[str, list[str]]]:
    topics = []
    for topic in _system().topic_names():
        types = {_full_type(end.type_name, "msg") for end in ends_of(topic) if end.node == node}
        if types:
            topics.append((topic, sorted(types)))
    return topics


def _of_actions(leaves: Mapping[str, str]) -> dict[str, list[str]]:
    """Return what each action that has a client or a server has below its name, with its types."""
    types_of: dict[str, list[str]] = {}
    for action, type_name in _system().action_names_and_types():
        package, _, name = type_name.partition("/")
        for leaf, pattern in leaves.items():
            types_of[f"{action}{OF_ACTION}{leaf}"] = [pattern.format(package=package, name=name)]
    return types_of


def _full_type(name: str, kind: str) -> str:
    package, _, short = name.partition("/")
    return f"{package}/{kind}/{short}"
