"""The calls of the master, with its replies unpacked and its refusals raised."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from urllib.parse import urlparse

from rospy.msproxy import MasterProxy

from .network import is_local_address
from .rosenv import get_master_uri


class MasterException(Exception):
    """The master refuses."""


class Failure(MasterException):
    """The master failed."""


class Error(MasterException):
    """The call was wrong."""


def is_online(master_uri: str | None = None) -> bool:
    """Return whether a master answers: that of the run, on this machine, and no other."""
    if master_uri is None or master_uri.rstrip("/") == get_master_uri().rstrip("/"):
        return True
    return is_local_address(urlparse(master_uri).hostname or "")


class _Handle:
    """The master's calls as XML-RPC has them, with the name of the caller first."""

    def __init__(self, uri: str) -> None:
        self._proxy = MasterProxy(uri)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        call = getattr(self._proxy, name, None)
        if call is None or name.startswith("_"):
            raise AttributeError(
                f"the master of tracerisk's stand-in has no {name}: in one process nodes need not "
                "be registered, and none learns of changes"
            )
        return lambda _, *arguments: call(*arguments)


class Master:
    """The master, as a caller of the name `caller_id` sees it.

    Each call returns the value of the master's reply, and raises Error for a call that is wrong,
    such as one for what does not exist, and Failure where the master failed.
    """

    def __init__(self, caller_id: str, master_uri: str | None = None) -> None:
        self.caller_id = caller_id
        self.master_uri = get_master_uri() if master_uri is None else master_uri
        self.handle: Any = _Handle(self.master_uri)

    def is_online(self) -> bool:
        """Return whether the master answers, as it does."""
        self.getPid()
        return True

    def getPid(self) -> Any:
        """Return the master's process."""
        return self._value("getPid")

    def getUri(self) -> Any:
        """Return the master's URI."""
        return self._value("getUri")

    def getParam(self, key: str) -> Any:
        """Return a parameter."""
        return self._value("getParam", key)

    def setParam(self, key: str, value: Any) -> Any:
        """Set a parameter."""
        return self._value("setParam", key, value)

    def hasParam(self, key: str) -> Any:
        """Return whether a parameter is set."""
        return self._value("hasParam", key)

    def deleteParam(self, key: str) -> Any:
        """Remove a parameter."""
        return self._value("deleteParam", key)

    def searchParam(self, key: str) -> Any:
        """Return the full name of a parameter."""
        return self._value("searchParam", key)

    def subscribeParam(self, caller_api: str, key: str) -> Any:
        """Return a parameter, of whose changes a node is to learn."""
        return self._value("subscribeParam", caller_api, key)

    def unsubscribeParam(self, caller_api: str, key: str) -> Any:
        """Return how many nodes were to learn of changes of a parameter."""
        return self._value("unsubscribeParam", caller_api, key)

    def getParamNames(self) -> Any:
        """Return the names of all parameters."""
        return self._value("getParamNames")

    def registerService(self, service: str, service_api: str, caller_api: str) -> Any:
        """Register a service."""
        return self._value("registerService", service, service_api, caller_api)

    def lookupService(self, service: str) -> Any:
        """Return the URI of a service."""
        return self._value("lookupService", service)

    def unregisterService(self, service: str, service_api: str) -> Any:
        """Remove a service."""
        return self._value("unregisterService", service, service_api)

    def registerSubscriber(self, topic: str, topic_type: str, caller_api: str) -> Any:
        """Register a subscriber; return the publishers of its topic."""
        return self._value("registerSubscriber", topic, topic_type, caller_api)

    def unregisterSubscriber(self, topic: str, caller_api: str) -> Any:
        """Remove a subscriber."""
        return self._value("unregisterSubscriber", topic, caller_api)

    def registerPublisher(self, topic: str, topic_type: str, caller_api: str) -> Any:
        """Register a publisher; return the subscribers of its topic."""
        return self._value("registerPublisher", topic, topic_type, caller_api)

    def unregisterPublisher(self, topic: str, caller_api: str) -> Any:
        """Remove a publisher."""
        return self._value("unregisterPublisher", topic, caller_api)

    def lookupNode(self, node_name: str) -> Any:
        """Return the URI of a node."""
        return self._value("lookupNode", node_name)

    def getPublishedTopics(self, subgraph: str) -> Any:
        """Return [name, type] of each topic below `subgraph` that somebody publishes."""
        return self._value("getPublishedTopics", subgraph)

    def getTopicTypes(self) -> Any:
        """Return [name, type] of each topic."""
        return self._value("getTopicTypes")

    def getSystemState(self) -> Any:
        """Return who publishes, subscribes and serves what."""
        return self._value("getSystemState")

    def _value(self, call: str, *arguments: Any) -> Any:
        code, message, value = getattr(self.handle, call)(self.caller_id, *arguments)
        if code == 1:
            return value
        raise Error(message) if code == -1 else Failure(message)
