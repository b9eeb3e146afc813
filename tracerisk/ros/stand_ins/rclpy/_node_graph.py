"""What a node sees of the graph."""

from __future__ import annotations

from typing import Any

from ._node_names import NodeNames
from ._run import run


class NodeGraph(NodeNames):
    """What a node sees of topics, services and other nodes; a part of `Node`."""

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return each topic with its types: `std_msgs/msg/String`."""
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
        run().scheduler.touch()
        return [
            (server.name, [_full_type(server.type_name, "srv")])
            for server in run().graph.services()
        ]

    def get_node_names(self) -> list[str]:
        """Return the names of the controller's nodes."""
        return [node.get_name() for node in run().nodes]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return names and namespaces of the controller's nodes."""
        return [(node.get_name(), node.get_namespace()) for node in run().nodes]

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publish on a topic."""
        run().scheduler.touch()
        return len(run().graph.publications(self.resolve_topic_name(topic_name)))

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscribe to a topic."""
        run().scheduler.touch()
        return len(run().graph.subscriptions(self.resolve_topic_name(topic_name)))


def _full_type(name: str, kind: str) -> str:
    package, _, short = name.partition("/")
    return f"{package}/{kind}/{short}"
