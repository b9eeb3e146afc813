"""The base of message classes, and what finds and prints them."""

import struct
from importlib import import_module
from typing import Any

from tracerisk.ros.messages.ros1_base import (
    DeserializationError,
    Message,
    MessageException,
    SerializationError,
)
from tracerisk.ros.messages.text import strify_message
from tracerisk.ros.time.rostime import Duration, Time

__all__ = [
    "DeserializationError",
    "Message",
    "MessageException",
    "SerializationError",
    "get_message_class",
    "get_service_class",
    "strify_message",
    "struct_I",
]

struct_I = struct.Struct("<I")


def get_message_class(message_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of `package/Name`, or None where there is none.

    Raises:
        ValueError: the name has no package.
    """
    primitive = {"time": Time, "duration": Duration}.get(message_type)
    return primitive if primitive is not None else _class(message_type, "msg")


def get_service_class(service_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of the service `package/Name`, or None where there is none.

    Raises:
        ValueError: the name has no package.
    """
    return _class(service_type, "srv")


def _class(name: str, kind: str) -> Any:
    package, _, short = ("std_msgs/Header" if name == "Header" else name).partition("/")
    if not short:
        raise ValueError(f"message type is missing package name: {name}")
    try:
        return getattr(import_module(f"{package}.{kind}"), short, None)
    except ImportError:
        return None
