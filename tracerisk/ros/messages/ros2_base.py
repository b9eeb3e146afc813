"""The bases of ROS 2 message, service and action classes."""

from __future__ import annotations

import array
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from tracerisk.ros.messages.ros2_fields import Field2

if TYPE_CHECKING:
    from typing_extensions import Self


class Message2:
    """A ROS 2 message: fields by keyword, each checked when it is assigned.

    Raises:
        AssertionError: a keyword is not a field, or a value does not fit its field.
    """

    __slots__: Sequence[str] = ()
    __hash__ = None  # type: ignore[assignment]  # messages are mutable and compare by value

    _ros_type: ClassVar[str] = ""
    _ros_fields: ClassVar[tuple[Field2, ...]] = ()
    _fields_and_field_types: ClassVar[dict[str, str]] = {}
    SLOT_TYPES: ClassVar[tuple[Any, ...]] = ()

    def __init__(self, **kwargs: Any) -> None:
        known = self._fields_and_field_types
        unknown = sorted(name for name in kwargs if name not in known)
        if unknown:
            text = ", ".join(unknown)
            raise AssertionError(f"Invalid arguments passed to constructor: {text}")
        for field in self._ros_fields:
            if field.name not in kwargs:
                object.__setattr__(self, f"_{field.name}", field.make_default())
                continue
            value = kwargs[field.name]
            if field.is_numbers:
                value = field.pack(value)
            setattr(self, field.name, value)

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return the fields' types by their names, in the order of the definition."""
        return dict(cls._fields_and_field_types)

    def __repr__(self) -> str:
        package, _, short = self._ros_type.partition("/")
        kind = type(self).__module__.split(".")[1]
        fields = [f"{f.name}={_shown(getattr(self, f.name))}" for f in self._ros_fields]
        return f"{package}.{kind}.{short}({', '.join(fields)})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return False
        return all(
            _equal(getattr(self, field.name), getattr(other, field.name))
            for field in self._ros_fields
        )

    def __copy__(self) -> Self:
        made = type(self).__new__(type(self))
        for slot in self.__slots__:
            object.__setattr__(made, slot, getattr(self, slot))
        return made

    def __getstate__(self) -> dict[str, Any]:
        return {slot: getattr(self, slot) for slot in self.__slots__}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for slot, value in state.items():
            object.__setattr__(self, slot, value)


class Service2:
    """A ROS 2 service: the classes of its request, its response, and of what reports a call."""

    _ros_type: ClassVar[str] = ""
    Request: ClassVar[type[Message2]]
    Response: ClassVar[type[Message2]]
    Event: ClassVar[type[Message2]]

    def __init__(self) -> None:
        raise NotImplementedError("Service classes can not be instantiated")


class Action2:
    """A ROS 2 action: the classes of its goal, result and feedback."""

    _ros_type: ClassVar[str] = ""
    Goal: ClassVar[type[Message2]]
    Result: ClassVar[type[Message2]]
    Feedback: ClassVar[type[Message2]]

    def __init__(self) -> None:
        raise NotImplementedError("Action classes can not be instantiated")


def copy_message(message: Any) -> Any:
    """Return a copy of a message, its nested messages and lists included, checked anew.

    A list may have been filled with what does not fit since it was assigned.

    Raises:
        AssertionError: a value does not fit its field.
        AttributeError: a field holds a time that is no message.
    """
    made = type(message)()
    for field in type(message)._ros_fields:
        setattr(made, field.name, _copy(field, getattr(message, field.name)))
    return made


def _copy(field: Field2, value: Any) -> Any:
    if isinstance(value, array.array | np.ndarray):
        return value[:] if isinstance(value, array.array) else value.copy()
    if field.arrangement != "scalar":
        field.accept(value)
        nested = field.message is not None
        return [copy_message(item) if nested else item for item in value]
    if field.message is None:
        return value
    if not isinstance(value, field.message):
        raise AttributeError(f"'{type(value).__name__}' object has no attribute 'sec'")
    return copy_message(value)


def _shown(value: Any) -> str:
    if isinstance(value, array.array):
        return repr(value.tolist())
    return repr(value)


def _equal(mine: Any, other: Any) -> bool:
    if isinstance(mine, np.ndarray) or isinstance(other, np.ndarray):
        return bool(np.array_equal(mine, other))
    return bool(mine == other)
