"""Messages from JSON, and JSON from messages."""

from __future__ import annotations

import json
from typing import Any

from .message_converter import (
    convert_dictionary_to_ros_message,
    convert_ros_message_to_dictionary,
)

__all__ = ["convert_json_to_ros_message", "convert_ros_message_to_json"]


def convert_json_to_ros_message(
    message_type: str, json_message: str, strict_mode: bool = True, log_level: str = "error"
) -> Any:
    """Return the message that a text in JSON says."""
    return convert_dictionary_to_ros_message(
        message_type, json.loads(json_message), strict_mode=strict_mode, log_level=log_level
    )


def convert_ros_message_to_json(message: Any, binary_array_as_bytes: bool = True) -> str:
    """Return what a message says in JSON."""
    return json.dumps(convert_ros_message_to_dictionary(message, binary_array_as_bytes))
