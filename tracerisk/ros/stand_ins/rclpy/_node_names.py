"""The names of a node, and how it expands and remaps those that it is given."""

from __future__ import annotations

import re
from typing import Any

from ._arguments import Arguments
from .exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)

_NODE_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_NAME = re.compile(r"~?(/?[A-Za-z_{}]\w*[\w{}]*)?(/[A-Za-z_{][\w{}]*)*", re.ASCII)


class NodeNames:
    """What a node does with names; a part of `Node`."""

    _sources: tuple[Arguments, ...]

    def _take_names(self, node_name: str, namespace: str | None) -> None:
        if not _NODE_NAME.fullmatch(node_name):
            raise InvalidNodeNameException(
                node_name,
                "node name must not be empty"
                if not node_name
                else "node name must not contain characters other than alphanumerics or '_', "
                "and must not start with a number",
                0,
            )
        self._given_name = node_name
        self._name = self._renamed("__node", "__name") or node_name
        self._namespace = _namespace(self._renamed("__ns") or namespace or "")

    def _renamed(self, *keys: str) -> str | None:
        for source in self._sources:
            for key in keys:
                found = source.remapped(self._given_name, key)
                if found is not None:
                    return found
        return None

    def get_name(self) -> str:
        """Return the name."""
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

    def _resolved(self, name: str, error: Any, *, remaps: bool = True) -> str:
        if not isinstance(name, str):
            raise TypeError(f"name must be a str, not {type(name).__name__}")
        if not name or not _NAME.fullmatch(name) or name == "/":
            told = (
                "name must not be empty"
                if not name
                else (
                    "name must hold nothing but alphanumerics, '_', '/', '~' and '{}', no part may "
                    "start with a number and it must not end with '/'"
                )
            )
            raise error(name, told, 0)
        full = self._expanded(name)
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
        text = name.replace("{node}", self._name)
        for key in ("{ns}", "{namespace}"):
            text = text.replace(key, self._namespace)
        if text.startswith("~"):
            return f"{self.get_fully_qualified_name()}/{text[1:].lstrip('/')}".rstrip("/")
        if text.startswith("/"):
            return re.sub("/+", "/", text)
        return f"{self._namespace.rstrip('/')}/{text}"


def _namespace(given: str) -> str:
    space = "/" + given.strip("/")
    if given != "/" and not re.fullmatch(r"(/|(/[A-Za-z_]\w*)+)", space, re.ASCII):
        raise InvalidNamespaceException(
            given,
            "namespace must hold nothing but alphanumerics, '_' and '/', and no part may start "
            "with a number",
            0,
        )
    return space
