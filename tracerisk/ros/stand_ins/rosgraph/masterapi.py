"""The calls of the master, with its replies unpacked and its refusals raised."""

from __future__ import annotations

from typing import Any

from rospy.msproxy import MasterProxy

from .rosenv import get_master_uri


class MasterException(Exception):
    """The master refuses."""


class Failure(MasterException):
    """The master failed."""


class Error(MasterException):
    """The call was wrong."""


def is_online(master_uri: str | None = None) -> bool:
    """Return whether the master answers, as it does."""
    return True


class Master:
    """The master, as a caller of the name `caller_id` sees it."""

    def __init__(self, caller_id: str, master_uri: str | None = None) -> None:
        self.caller_id = caller_id
        self.master_uri = get_master_uri() if master_uri is None else master_uri
        self._proxy = MasterProxy(self.master_uri)

    def is_online(self) -> bool:
        """Return whether the master answers, as it does."""
        return True

    def getPid(self) -> Any:
        """Return the master's process."""
        return _value(self._proxy.getPid())

    def getUri(self) -> Any:
        """Return the master's URI."""
        return _value(self._proxy.getUri())

    def getParam(self, key: str) -> Any:
        """Return a parameter.

        Raises:
            Error: it is not set.
        """
        return _value(self._proxy.getParam(key))

    def setParam(self, key: str, value: Any) -> None:
        """Set a parameter."""
        _value(self._proxy.setParam(key, value))

    def hasParam(self, key: str) -> Any:
        """Return whether a parameter is set."""
        return _value(self._proxy.hasParam(key))

    def deleteParam(self, key: str) -> None:
        """Remove a parameter.

        Raises:
            Error: it is not set.
        """
        _value(self._proxy.deleteParam(key))

    def searchParam(self, key: str) -> Any:
        """Return the full name of a parameter.

        Raises:
            Error: it is not set.
        """
        return _value(self._proxy.searchParam(key))

    def getParamNames(self) -> Any:
        """Return the names of all parameters."""
        return _value(self._proxy.getParamNames())

    def getPublishedTopics(self, subgraph: str) -> Any:
        """Return [name, type] of each topic below `subgraph` that somebody publishes."""
        return _value(self._proxy.getPublishedTopics(subgraph))

    def getTopicTypes(self) -> Any:
        """Return [name, type] of each topic."""
        return _value(self._proxy.getTopicTypes())

    def getSystemState(self) -> Any:
        """Return who publishes, subscribes and serves what."""
        return _value(self._proxy.getSystemState())

    def lookupService(self, service: str) -> Any:
        """Return the URI of a service.

        Raises:
            Error: nobody serves it.
        """
        return _value(self._proxy.lookupService(service))

    def lookupNode(self, node_name: str) -> Any:
        """Return the URI of a node.

        Raises:
            Error: it is not known.
        """
        return _value(self._proxy.lookupNode(node_name))


def _value(reply: tuple[int, str, Any]) -> Any:
    code, message, value = reply
    if code == 1:
        return value
    raise Error(message) if code == -1 else Failure(message)
