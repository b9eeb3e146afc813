"""Messages and services by the name of their type."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from genpy import DeserializationError, Message, SerializationError

__all__ = [
    "DeserializationError",
    "Message",
    "SerializationError",
    "get_message_class",
    "get_service_class",
]


def get_message_class(message_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of `package/Name`, or None if there is none."""
    return _class_of(message_type, "msg")


def get_service_class(service_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of `package/Name`, or None if there is none."""
    return _class_of(service_type, "srv")


def _class_of(type_name: str, kind: str) -> Any:
    package, _, name = type_name.partition("/")
    if not name:
        raise ValueError(f"type name [{type_name}] is not a package/Name")
    try:
        return getattr(import_module(f"{package}.{kind}"), name, None)
    except ImportError:
        return None
