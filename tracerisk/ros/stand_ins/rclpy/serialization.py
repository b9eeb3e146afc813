"""Messages as bytes and back."""

from __future__ import annotations

from typing import Any

from tracerisk.ros.messages.ros2_wire import decode, encode

from ._rclpy_pybind11 import RCLError
from .type_support import check_for_type_support


def serialize_message(message: Any) -> bytes:
    """Return a message's bytes, as they would be sent.

    Raises:
        NoTypeSupportImportedException: it is not a message of ROS 2.
    """
    check_for_type_support(type(message))
    return encode(message)


def deserialize_message(serialized_message: bytes, message_type: Any) -> Any:
    """Return the message of bytes.

    Raises:
        NoTypeSupportImportedException: `message_type` is not a message class of ROS 2.
        RCLError: the bytes are none of such a message.
    """
    check_for_type_support(message_type)
    try:
        return decode(bytes(serialized_message), message_type)
    except ValueError as error:
        raise RCLError(f"failed to deserialize ROS message: {error}") from error
