"""The fields of message classes of either ROS, and the parts of interfaces, by one set of words."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

INTEGER_BITS = {
    "int8": 8,
    "int16": 16,
    "int32": 32,
    "int64": 64,
    "uint8": 8,
    "uint16": 16,
    "uint32": 32,
    "uint64": 64,
    "byte": 8,
    "char": 8,
}
FLOATS = frozenset({"float32", "float64"})
TIMES = frozenset({"time", "builtin_interfaces/Time"})
DURATIONS = frozenset({"duration", "builtin_interfaces/Duration"})
_ROS1_BYTES = frozenset({"uint8", "char"})


@dataclass(frozen=True, slots=True)
class MessageField:
    """A field of a message of either ROS."""

    name: str
    """The name of the field."""
    base: str
    """The type without its array part."""
    is_array: bool
    """Whether it is an array or a sequence."""
    length: int | None
    """The length of a fixed array; `None` for all others."""
    longest: int | None
    """The upper bound of a sequence; `None` where it is unbounded."""
    message: type | None
    """The class of a nested message; `None` for primitives."""
    is_ros2: bool
    """Whether the message is of ROS 2."""
    default: Any = None
    """The default that the definition sets; `None` where it sets none, as always in ROS 1."""

    @property
    def type_text(self) -> str:
        """The type in words: `float64[3]`."""
        if not self.is_array:
            return self.base
        return f"{self.base}[{'' if self.length is None else self.length}]"

    @property
    def is_bytes(self) -> bool:
        """Whether the value is `bytes`: uint8[] of ROS 1."""
        return self.is_array and not self.is_ros2 and self.base in _ROS1_BYTES

    @property
    def integer_limits(self) -> tuple[int, int] | None:
        """The least and the greatest value of an integer field; None for another."""
        bits = INTEGER_BITS.get(self.base)
        if bits is None:
            return None
        is_signed = self.base.startswith("int") or (self.base == "byte" and not self.is_ros2)
        return (-(1 << bits - 1), (1 << bits - 1) - 1) if is_signed else (0, (1 << bits) - 1)


def fields_of(message_class: Any) -> tuple[MessageField, ...]:
    """Return the fields of a message class, in the order of its definition."""
    if hasattr(message_class, "_ros_fields"):
        return tuple(
            MessageField(
                field.name,
                field.base,
                field.arrangement != "scalar",
                field.size if field.arrangement == "array" else None,
                field.size if field.arrangement == "sequence" else None,
                field.message,
                True,
                field.default,
            )
            for field in message_class._ros_fields
        )
    return tuple(
        MessageField(
            field.name, field.base, field.is_array, field.length, None, field.message, False
        )
        for field in message_class._fields
    )


def constants_of(message_class: type) -> dict[str, Any]:
    """Return the constants of a message class by their names."""
    return {
        name: value
        for name, value in vars(message_class).items()
        if not name.startswith("_")
        and name != "SLOT_TYPES"
        and isinstance(value, bool | int | float | str | bytes)
    }


def known_constants(message_class: Any, deep: int = 2) -> dict[str, Any]:
    """Return the constants of a message class and of its nested ones, down to a depth, by name."""
    constants = constants_of(message_class)
    for field in fields_of(message_class) if deep else ():
        if field.message is not None:
            constants = known_constants(field.message, deep - 1) | constants
    return constants


def type_of(message_class: Any) -> str:
    """Return the name of a message class: `geometry_msgs/Pose`."""
    return str(getattr(message_class, "_ros_type", "") or message_class._type)


def snake_case(name: str) -> str:
    """Return a type's name as rosidl names its module: `pose_stamped` of `PoseStamped`."""
    split = re.sub(r"(.)([A-Z][a-z]+)", r"\1_\2", name)
    return re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", split).lower()


def service_parts(interfaces: Any, type_name: str) -> tuple[Any, Any]:
    """Return the classes of a service's request and response, of either ROS.

    Raises:
        InputError: no such service is known.
    """
    service = interfaces.service(type_name)
    if hasattr(service, "_request_class"):
        return service._request_class, service._response_class
    return service.Request, service.Response


def action_parts(interfaces: Any, type_name: str) -> tuple[Any, Any]:
    """Return the classes of an action's result and feedback, of either ROS.

    Raises:
        InputError: no such action is known.
    """
    if hasattr(interfaces, "action"):
        action = interfaces.action(type_name)
        return action.Result, action.Feedback
    return interfaces.message(f"{type_name}Result"), interfaces.message(f"{type_name}Feedback")


def goal_class(interfaces: Any, type_name: str) -> Any:
    """Return the class of an action's goal, of either ROS.

    Raises:
        InputError: no such action is known.
    """
    if hasattr(interfaces, "action"):
        return interfaces.action(type_name).Goal
    return interfaces.message(f"{type_name}Goal")
