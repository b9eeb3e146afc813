"""Classes of interfaces by their names: `std_msgs/msg/String`, or without the part between."""

from __future__ import annotations

import importlib
from typing import Any


def get_interface(identifier: str) -> Any:
    """Return an interface by its full name.

    Raises:
        ModuleNotFoundError: no such package is known.
        AttributeError: the package has no such interface.
    """
    return _find(identifier, None)


def get_message(identifier: str) -> Any:
    """Return a message class; see `get_interface`.

    Raises:
        ValueError: the name is one of another kind.
    """
    return _of_kind(identifier, "msg", "a message", is_message)


def get_service(identifier: str) -> Any:
    """Return a service class; see `get_message`."""
    return _of_kind(identifier, "srv", "a service", is_service)


def get_action(identifier: str) -> Any:
    """Return an action class; see `get_message`."""
    return _of_kind(identifier, "action", "an action", is_action)


def is_message(interface: Any) -> bool:
    """Return whether a class is one of a message."""
    return hasattr(interface, "SLOT_TYPES")


def is_service(interface: Any) -> bool:
    """Return whether a class is one of a service."""
    return hasattr(interface, "Request") and hasattr(interface, "Response")


def is_action(interface: Any) -> bool:
    """Return whether a class is one of an action."""
    return all(hasattr(interface, part) for part in ("Goal", "Result", "Feedback"))


def _of_kind(identifier: str, space: str, text: str, is_kind: Any) -> Any:
    of_kind = _find(identifier, space)
    if not is_kind(of_kind):
        raise ValueError(f"Expected the full name of {text}, got '{identifier}'")
    return of_kind


def _find(identifier: str, space: str | None) -> Any:
    *spaces, name = identifier.split("/")
    if len(spaces) == 1 and space is not None:
        spaces.append(space)
    return getattr(importlib.import_module(".".join(spaces)), name)
