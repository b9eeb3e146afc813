"""Messages from dictionaries, and dictionaries from messages.

Names, signatures, defaults and errors are those of DFKI-NI/rospy_message_converter
src/rospy_message_converter/message_converter.py.
"""

from __future__ import annotations

import base64
import logging
from collections.abc import Mapping
from typing import Any

import numpy as np
import roslib.message
import rospy

__all__ = ["convert_dictionary_to_ros_message", "convert_ros_message_to_dictionary"]

_WHOLE = ("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "byte", "char")
_REAL = ("float32", "float64")
_PLAIN = frozenset({"bool", "string", *_WHOLE, *_REAL})
_TIMES = {"time": rospy.Time, "duration": rospy.Duration}
_BYTES = ("uint8[", "char[")
_LEVELS = frozenset({"debug", "info", "warning", "error", "critical"})


def convert_dictionary_to_ros_message(
    message_type: str,
    dictionary: Mapping[str, Any] | None,
    kind: str = "message",
    strict_mode: bool = True,
    check_missing_fields: bool = False,
    check_types: bool = True,
    log_level: str = "error",
) -> Any:
    """Return a message, a request or a response with the fields of a dictionary.

    Raises:
        ValueError: an unknown kind or field, or a field that is missing and has to be there.
        TypeError: a number, text or truth value of another type than the field's.
    """
    message = _empty(message_type, kind)
    types = dict(zip(message.__slots__, message._slot_types, strict=True))
    options = strict_mode, check_missing_fields, check_types, log_level
    left = dict(types)
    for name, value in (dictionary or {}).items():
        if name not in types:
            words = f'ROS message type "{message_type}" has no field named "{name}"'
            if strict_mode:
                raise ValueError(words)
            level = log_level if log_level in _LEVELS else "error"
            getattr(logging.getLogger("rosout"), level)(f"{words}! It will be ignored.")
            continue
        if value is not None:
            setattr(message, name, _to_field(name, types[name], value, options))
        del left[name]
    if check_missing_fields and left:
        raise ValueError(f'Missing fields "{left}"')
    return message


def convert_ros_message_to_dictionary(message: Any, binary_array_as_bytes: bool = True) -> Any:
    """Return the fields of a message by name; bytes as a text in base 64, or as numbers."""
    return {
        name: _from_field(kind, getattr(message, name), binary_array_as_bytes)
        for name, kind in zip(message.__slots__, message._slot_types, strict=True)
    }


def _empty(message_type: str, kind: str) -> Any:
    if kind == "message":
        return roslib.message.get_message_class(message_type)()
    if kind not in ("request", "response"):
        raise ValueError(f'Unknown kind "{kind}".')
    service = roslib.message.get_service_class(message_type)
    return service._request_class() if kind == "request" else service._response_class()


def _to_field(name: str, kind: str, value: Any, options: tuple[bool, bool, bool, str]) -> Any:
    if kind.startswith(_BYTES):
        return base64.b64decode(value, validate=True) if isinstance(value, str) else bytes(value)
    if kind in _TIMES:
        if kind == "time" and value == "now":
            return rospy.get_rostime()
        made = _TIMES[kind]()
        for part in ("secs", "nsecs"):
            if value.get(part) is not None:
                setattr(made, part, value[part])
        return made
    base, bracket, _ = kind.partition("[")
    if base in _PLAIN:
        if not bracket and options[2] and not _fits(kind, value):
            raise TypeError(f"Field '{name}' has wrong type {type(value)} (it is a {kind})")
        return value
    if bracket:
        return [_to_field(name, base, part, options) for part in value]
    strict_mode, check_missing_fields, check_types, log_level = options
    return convert_dictionary_to_ros_message(
        base,
        value,
        strict_mode=strict_mode,
        check_missing_fields=check_missing_fields,
        check_types=check_types,
        log_level=log_level,
    )


def _fits(kind: str, value: Any) -> bool:
    if kind == "bool":
        return type(value) is bool
    if kind == "string":
        return type(value) is str
    if isinstance(value, np.generic):
        return np.can_cast(value.dtype, {"byte": "int8", "char": "uint8"}.get(kind, kind), "safe")
    return type(value) is int or (kind in _REAL and type(value) is float)


def _from_field(kind: str, value: Any, as_text: bool) -> Any:
    if kind.startswith(_BYTES):
        return base64.b64encode(bytes(value)).decode() if as_text else list(value)
    if kind in _TIMES:
        return {"secs": value.secs, "nsecs": value.nsecs}
    base, bracket, _ = kind.partition("[")
    if base in _PLAIN:
        return list(value) if bracket else value
    if bracket:
        return [_from_field(base, part, as_text) for part in value]
    return convert_ros_message_to_dictionary(value, as_text)
