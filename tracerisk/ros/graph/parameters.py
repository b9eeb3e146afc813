"""The parameter server: a tree of values under global names."""

from __future__ import annotations

import copy
import datetime as dt
from collections.abc import Callable, Iterator
from typing import Any

from tracerisk.ros.graph import graph_names

_LIMIT = 2**31


class ParameterTree:
    """Parameters by global name; a namespace reads as a dictionary of what it holds."""

    def __init__(self) -> None:
        self._root: dict[str, Any] = {}
        self._offers: dict[str, Callable[[], Any]] = {}
        self._asked: set[tuple[str, ...]] = set()
        self._beyond: Callable[[str], Any] = lambda _: None

    def ask(self, name: str) -> None:
        """Note that a parameter was asked for: `/pick/speed`, or the name that a node declares."""
        self._asked.add(tuple(_parts(name.replace(".", graph_names.SEP))))

    def is_asked(self, name: str) -> bool:
        """Return whether anybody asked for a parameter, its namespace or something below it.

        A name without its namespace counts: `speed` for `/pick/speed`, and the other way round.
        """
        parts = tuple(_parts(name.lstrip("~").replace(".", graph_names.SEP)))
        return any(
            (len(asked) <= len(parts) and asked in (parts[: len(asked)], parts[-len(asked) :]))
            or any(
                asked[at : at + len(parts)] == parts for at in range(len(asked) - len(parts) + 1)
            )
            for asked in self._asked
        )

    def fall_back_on(self, beyond: Callable[[str], Any]) -> None:
        """Use `beyond` for names that are not set and have no other value.

        It returns None for what it does not know either.
        """
        self._beyond = beyond

    def beyond(self, name: str) -> Any:
        """Return what stands in for a parameter that is not set, None for nothing."""
        return self._beyond(name)

    def offer(self, base_name: str, value: Callable[[], Any]) -> None:
        """Provide `/base_name`, or `/robot/base_name` for any robot, where it is not set.

        A global name is offered as it is.
        It is what the driver of a robot sets when it starts.
        `value` returns None as long as no such driver is there.
        """
        self._offers[base_name] = value

    def get(self, name: str) -> Any:
        """Return a copy of a value, or of the dictionary of a namespace.

        Raises:
            KeyError: the parameter is not set.
        """
        self.ask(name)
        value: Any = self._root
        for part in _parts(name):
            if not isinstance(value, dict) or part not in value:
                value = self._offered(name)
                if value is None:
                    raise KeyError(name)
                break
            value = value[part]
        return copy.deepcopy(value)

    def set(self, name: str, value: Any) -> None:
        """Set a value; a dictionary replaces the whole namespace.

        Raises:
            TypeError: the value is of a type that the server cannot hold, or the root is given
                one that is not a dictionary.
            OverflowError: an integer of more than 32 bits.
        """
        kept = _storable(value)
        parts = _parts(name)
        if not parts:
            if not isinstance(kept, dict):
                raise TypeError("cannot set root of parameter tree to non-dictionary")
            self._root = kept
            return
        space = self._root
        for part in parts[:-1]:
            inner = space.get(part)
            if not isinstance(inner, dict):
                inner = space[part] = {}
            space = inner
        space[parts[-1]] = kept

    def delete(self, name: str) -> None:
        """Remove a parameter or a namespace.

        Raises:
            KeyError: it is not set, or is the root.
        """
        parts = _parts(name)
        space: Any = self._root
        for part in parts[:-1]:
            if not isinstance(space, dict) or part not in space:
                raise KeyError(name)
            space = space[part]
        if not parts or not isinstance(space, dict) or parts[-1] not in space:
            raise KeyError(name)
        del space[parts[-1]]

    def set_default(self, name: str, value: Any) -> None:
        """Set a value where there is none; see `set`."""
        if not self._holds(name):
            self.set(name, value)

    def has(self, name: str) -> bool:
        """Return whether a parameter or a namespace is set."""
        self.ask(name)
        return self._holds(name)

    def _holds(self, name: str) -> bool:
        return self._holds_itself(name) or self._offered(name) is not None

    def _holds_itself(self, name: str) -> bool:
        value: Any = self._root
        for part in _parts(name):
            if not isinstance(value, dict) or part not in value:
                return False
            value = value[part]
        return True

    def search(self, node: str, key: str) -> str | None:
        """Return the full name of `key`, looked for from the node's own names up to the root.

        Only the first part of `key` is looked for, as the real server does.

        Raises:
            ValueError: `key` is empty or private.
        """
        if not key or graph_names.is_private(key):
            raise ValueError(f"invalid key [{key}]")
        if graph_names.is_global(key):
            return key if self.has(key) else None
        first = _parts(key)[0]
        spaces = _parts(node)
        for depth in range(len(spaces), -1, -1):
            space = graph_names.SEP + graph_names.SEP.join(spaces[:depth])
            if self.has(graph_names.join(space, first)):
                return graph_names.join(space, key)
        return None

    def _offered(self, name: str) -> Any:
        """Return what is offered of a name: a value, or one within a dictionary."""
        parts = _parts(name)
        for end in range(len(parts), 0, -1):
            offered = self._offers.get(graph_names.SEP + graph_names.SEP.join(parts[:end]))
            if offered is None and end <= 2:
                offered = self._offers.get(parts[end - 1])
            value = None if offered is None else offered()
            for part in parts[end:]:
                value = value.get(part) if isinstance(value, dict) else None
            if value is not None:
                return value
        return None

    def names(self) -> list[str]:
        """Return the global names of all values, sorted."""
        return sorted(_leaves("", self._root))

    def offered_names(self) -> list[str]:
        """Return the global names of what is offered, sorted."""
        names: set[str] = set()
        for base_name, offered in self._offers.items():
            name = (
                base_name if graph_names.is_global(base_name) else f"{graph_names.SEP}{base_name}"
            )
            value = None if self._holds_itself(name) else offered()
            names.update(() if value is None else _leaves(name, value))
        return sorted(names)


def _parts(name: str) -> list[str]:
    return [part for part in name.split(graph_names.SEP) if part]


def _leaves(prefix: str, value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(f"{prefix}/{key}", inner)
    else:
        yield prefix


def _storable(value: Any) -> Any:
    """Return what the server keeps of a value: its wire format knows few types."""
    if isinstance(value, dict):
        for key in value:
            if not isinstance(key, str):
                raise TypeError("dictionary key must be string")
        return {key: _storable(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_storable(inner) for inner in value]
    if type(value) is int and not -_LIMIT <= value < _LIMIT:
        raise OverflowError("int exceeds XML-RPC limits")
    if value is None:
        raise TypeError("cannot marshal None unless allow_none is enabled")
    if type(value) in (bool, int, float, str, bytes) or isinstance(value, dt.datetime):
        return value
    raise TypeError(f"cannot marshal {type(value)} objects")
