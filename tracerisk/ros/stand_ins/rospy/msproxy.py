"""The master, as far as one process has one."""

from __future__ import annotations

from typing import Any

from tracerisk.ros.controller.needs import Need
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.robot.bring_up.system import SystemState

from ._node import NodeState, node
from .names import resolve_name

MASTER_URI = "http://localhost:11311/"
_Reply = tuple[int, str, Any]


class MasterProxy:
    """The master's calls, and its parameters like a dictionary: `master["/speed"] = 1.0`."""

    def __init__(self, uri: str = MASTER_URI) -> None:
        self.uri = uri

    def __getitem__(self, key: str) -> Any:
        name = resolve_name(key)
        state = node()
        if not state.graph.parameters.has(name):
            state.scheduler.miss(Need("parameter", name))
            state.scheduler.touch()
            raise KeyError(key)
        state.scheduler.needs.meet(Need("parameter", name))
        return state.graph.parameters.get(name)

    def __setitem__(self, key: str, val: Any) -> None:
        node().graph.parameters.set(resolve_name(key), val)

    def __delitem__(self, key: str) -> None:
        try:
            node().graph.parameters.delete(resolve_name(key))
        except KeyError:
            raise KeyError(key) from None

    def __contains__(self, key: str) -> bool:
        state = node()
        state.scheduler.touch()
        name = resolve_name(key)
        parameters = state.graph.parameters
        is_set = parameters.has(name) or parameters.beyond(name) is not None
        if not is_set:
            state.scheduler.needs.ask(Need("parameter", name), state.scheduler.now_ns)
        return is_set

    def get_param_cached(self, key: str) -> Any:
        """Return a parameter."""
        return self[key]

    def search_param(self, key: str) -> str | None:
        """Return the full name of a parameter looked for from the node's names up to the root."""
        state = node()
        return state.graph.parameters.search(state.name, state.mappings.get(key, key))

    def getParam(self, key: str) -> _Reply:
        """Return a parameter as the master's reply."""
        if key not in self:
            return -1, f"Parameter [{key}] is not set", 0
        return 1, f"Parameter [{key}]", self[key]

    def setParam(self, key: str, val: Any) -> _Reply:
        """Set a parameter."""
        self[key] = val
        return 1, f"parameter {key} set", 0

    def hasParam(self, key: str) -> _Reply:
        """Return whether a parameter is set."""
        return 1, resolve_name(key), key in self

    def deleteParam(self, key: str) -> _Reply:
        """Remove a parameter."""
        if key not in self:
            return -1, f"parameter [{key}] is not set", 0
        del self[key]
        return 1, f"parameter {key} deleted", 0

    def searchParam(self, key: str) -> _Reply:
        """Look for a parameter."""
        search_param = self.search_param(key)
        if search_param is None:
            return -1, f"Cannot find parameter [{key}] in an upwards search", ""
        return 1, "Found", search_param

    def getParamNames(self) -> _Reply:
        """Return the names of all parameters."""
        parameters = node().graph.parameters
        names = sorted({*parameters.names(), *parameters.offered_names()})
        return 1, "Parameter names", names

    def getPublishedTopics(self, subgraph: str = "/") -> _Reply:
        """Return [name, type] of each topic below `subgraph` that somebody publishes."""
        state = node()
        state.scheduler.touch()
        space = resolve_name(subgraph).rstrip("/") + "/"
        topics = [list(pair) for pair in _published(state) if pair[0].startswith(space)]
        return 1, "current topics", topics

    def getTopicTypes(self) -> _Reply:
        """Return [name, type] of each topic."""
        return 1, "current topics", [list(pair) for pair in _published(node())]

    def getSystemState(self) -> _Reply:
        """Return who publishes, subscribes and serves what."""
        state = node()
        state.scheduler.touch()
        system = state.runtime.client(SystemState)
        publishers, subscribers = [], []
        for name in system.topic_names():
            if nodes := sorted({publication.node for publication in system.publications(name)}):
                publishers.append([name, nodes])
            if nodes := sorted({subscription.node for subscription in system.subscriptions(name)}):
                subscribers.append([name, nodes])
        services = [[service.topic, [service.node]] for service in system.services()]
        return 1, "current system state", [publishers, subscribers, services]

    def lookupService(self, service: str) -> _Reply:
        """Return the URI of a service."""
        state = node()
        state.scheduler.touch()
        name = resolve_name(service)
        if state.graph.services.find(name) is None:
            return -1, f"no provider for service [{name}]", ""
        return 1, "rosrpc URI", "rosrpc://localhost:0"

    def lookupNode(self, node_name: str) -> _Reply:
        """Return the URI of a node."""
        known = (node().name, *node().runtime.client(SystemState).nodes())
        if resolve_name(node_name) in known:
            return 1, "node api", "http://localhost:11312/"
        return -1, f"unknown node [{node_name}]", ""

    def getUri(self) -> _Reply:
        """Return the master's URI."""
        return 1, "", self.uri

    def getPid(self) -> _Reply:
        """Return the master's process, which there is none of."""
        return 1, "", 1


def _published(state: NodeState) -> list[tuple[str, str]]:
    """Return name and type of every topic with a publisher, those of actions among them."""
    topics = state.runtime.client(Actions).published_topics()
    return sorted({*state.runtime.client(SystemState).published_topics(), *topics})
