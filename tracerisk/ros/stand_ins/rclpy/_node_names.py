"""The names of a node, and how it expands and remaps those that it is given."""

from __future__ import annotations

from typing import Any

from ._arguments import Arguments
from ._handle import Handle, check_context
from ._name_rules import check, full_topic_name_fault, namespace_fault, topic_name_fault
from .context import Context
from .exceptions import (
    InvalidNamespaceException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)
from .expand_topic_name import expanded
from .validate_node_name import validate_node_name


class NodeNames:
    """What a node does with names; a part of `Node`."""

    _sources: tuple[Arguments, ...]
    _handle: Handle
    _context: Context

    def _check_usable(self, doing: str) -> None:
        """Refuse what a destroyed node does no longer, and one whose context was shut down.

        Raises:
            InvalidHandle: the node was destroyed.
            RCLError: the context was shut down; `doing` says what failed.
        """
        with self._handle:
            check_context(self._context, doing)

    def _take_names(self, node_name: str, namespace: str | None) -> None:
        validate_node_name(node_name)
        self._given_name = node_name
        self._name = self._renamed("__node", "__name") or node_name
        self._namespace = _namespace(self._renamed("__ns") or namespace or "")

    def _renamed(self, *keys: str) -> str | None:
        for source in self._sources:
            for key in keys:
                text = source.remapped(self._given_name, key)
                if text is not None:
                    return text
        return None

    def get_name(self) -> str:
        """Return the name."""
        with self._handle:
            return self._name

    def get_namespace(self) -> str:
        """Return the namespace: `/`, or with no slash at its end."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Return namespace and name."""
        return f"{self._namespace.rstrip('/')}/{self._name}"

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the full name of a topic, remapped unless `only_expand`.

        Raises:
            InvalidTopicNameException: it is not one that ROS takes.
        """
        return self._resolved(topic, InvalidTopicNameException, remaps=not only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the full name of a service, remapped unless `only_expand`.

        Raises:
            InvalidServiceNameException: it is not one that ROS takes.
        """
        return self._resolved(service, InvalidServiceNameException, remaps=not only_expand)

    def _resolved_action(self, name: str, whose: str) -> str:
        """Return the full name of an action.

        Raises:
            ValueError: it is not one that ROS takes.
        """

        def error(given: str, message: str, _place: int) -> Exception:
            return ValueError(
                f"Failed to create action {whose} due to invalid topic name '{given}' : {message}"
            )

        return self._resolved(name, error)

    def _resolved(self, name: str, error: Any, *, remaps: bool = True) -> str:
        with self._handle:
            pass
        if not isinstance(name, str):
            raise TypeError(f"name must be a str, not {type(name).__name__}")
        check(name, topic_name_fault(name), error)
        full = self._expanded(name)
        check(full, full_topic_name_fault(full), error)
        if not remaps:
            return full
        for source in self._sources:
            for whom, old, new in source.remaps:
                if whom not in (None, self._name) or old.startswith("__"):
                    continue
                if self._expanded(old) == full:
                    return self._expanded(new)
        return full

    def _expanded(self, name: str) -> str:
        return expanded(name, self._name, self._namespace)


def _namespace(given: str) -> str:
    space = "/" + given.strip("/")
    check(given, namespace_fault(space), InvalidNamespaceException)
    return space
