"""What a node sees of the graph."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._node_names import NodeNames
from ._rclpy_pybind11 import NodeNameNonExistentError
from ._run import run
from .expand_topic_name import expand_topic_name
from .qos import QoSProfile
from .topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum


class NodeGraph(NodeNames):
    """What a node sees of topics, services and other nodes; a part of `Node`."""

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return each topic with its types: `std_msgs/msg/String`."""
        self._check_usable("failed to get topic names and types")
        graph = run().graph
        found = []
        run().scheduler.touch()
        for name in graph.topic_names():
            ends: list[Any] = [*graph.publications(name), *graph.subscriptions(name)]
            if ends:
                found.append((name, sorted({_full_type(end.type_name, "msg") for end in ends})))
        return found

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        """Return each service with its types: `std_srvs/srv/Trigger`."""
        self._check_usable("failed to get service names and types")
        run().scheduler.touch()
        return [
            (server.name, [_full_type(server.type_name, "srv")])
            for server in run().graph.services()
        ]

    def get_node_names(self) -> list[str]:
        """Return the names of the controller's nodes."""
        self._check_usable("Failed to get node names")
        return [node.get_name() for node in _living()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return names and namespaces of the controller's nodes."""
        self._check_usable("Failed to get node names")
        return [(node.get_name(), node.get_namespace()) for node in _living()]

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publish on a topic."""
        self._check_usable("Error in rcl_count_publishers")
        run().scheduler.touch()
        return len(run().graph.publications(self._checked_topic(topic_name)))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscribe to a topic."""
        self._check_usable("Error in rcl_count_subscribers")
        run().scheduler.touch()
        return len(run().graph.subscriptions(self._checked_topic(topic_name)))

    def count_clients(self, service_name: str) -> int:
        """Return how many of the controller's clients call a service."""
        self._check_usable("Error in rcl_count_clients")
        name = self._checked_service(service_name)
        return sum(each._full_name == name for node in run().nodes for each in node.clients)

    def count_services(self, service_name: str) -> int:
        """Return how many serve a service."""
        self._check_usable("Error in rcl_count_services")
        run().scheduler.touch()
        name = self._checked_service(service_name)
        return sum(server.name == name for server in run().graph.services())

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return the full names of the controller's nodes."""
        return [node.get_fully_qualified_name() for node in _living()]

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Return names, namespaces and enclaves of the controller's nodes."""
        return [(node.get_name(), node.get_namespace(), "/") for node in _living()]

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
        return _topics_of(self._known(node_name, node_namespace), run().graph.publications)

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]:
        """Return the topics to which a node subscribes, with their types; see the last."""
        return _topics_of(self._known(node_name, node_namespace), run().graph.subscriptions)

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> list[tuple[str, list[str]]]:
        """Return the services of a node with their types; see the last but one."""
        name = self._known(node_name, node_namespace)
        return [
            (server.name, [_full_type(server.type_name, "srv")])
            for server in run().graph.services()
            if server.node == name
        ]

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> list[tuple[str, list[str]]]:
        """Return the services that a node of the controller calls, with their types."""
        name = self._known(node_name, node_namespace)
        found = {
            each._full_name: _full_type(each.srv_type._ros_type, "srv")
            for node in run().nodes
            if node.get_fully_qualified_name() == name
            for each in node.clients
        }
        return [(service, [type_name]) for service, type_name in sorted(found.items())]

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
        graph, name = run().graph, self._checked_topic(topic)
        publishes = kind is TopicEndpointTypeEnum.PUBLISHER
        ends: Any = graph.publications(name) if publishes else graph.subscriptions(name)
        found = []
        for end in ends:
            handler = end.on_connect if publishes else end.deliver
            profile = getattr(getattr(handler, "__self__", None), "qos_profile", None)
            space, _, short = end.node.rpartition("/")
            found.append(
                TopicEndpointInfo(
                    short,
                    space or "/",
                    _full_type(end.type_name, "msg"),
                    kind,
                    qos_profile=QoSProfile(depth=10) if profile is None else profile,
                )
            )
        return found

    def _known(self, node_name: str, node_namespace: str) -> str:
        name = f"{node_namespace.rstrip('/')}/{node_name}"
        graph = run().graph
        known = set(self.get_fully_qualified_node_names())
        for topic in graph.topic_names():
            known |= {end.node for end in graph.publications(topic)}
            known |= {end.node for end in graph.subscriptions(topic)}
        if name not in known:
            raise NodeNameNonExistentError(
                f"Cannot get topic names and types for nonexistent node '{name}'"
            )
        return name


def _living() -> list[Any]:
    """Return the controller's nodes that others see: not those of a context that was shut down."""
    return [node for node in run().nodes if node.context.is_valid]


def _topics_of(node: str, ends_of: Callable[[str], Any]) -> list[tuple[str, list[str]]]:
    found = []
    for topic in run().graph.topic_names():
        types = {_full_type(end.type_name, "msg") for end in ends_of(topic) if end.node == node}
        if types:
            found.append((topic, sorted(types)))
    return found


def _full_type(name: str, kind: str) -> str:
    package, _, short = name.partition("/")
    return f"{package}/{kind}/{short}"
