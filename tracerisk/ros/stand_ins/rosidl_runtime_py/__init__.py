"""Stand-in for rosidl_runtime_py: messages of ROS 2 as dictionaries and texts, types by name."""

from __future__ import annotations

from .convert import message_to_csv, message_to_ordereddict, message_to_yaml
from .set_message import set_message_fields

__all__ = ["message_to_csv", "message_to_ordereddict", "message_to_yaml", "set_message_fields"]
