"""The bases of ROS 2 message, service and action classes."""

from __future__ import annotations

import array
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from tracerisk.ros.messages.misfits import abort_sending
from tracerisk.ros.messages.ros2_fields import Field2

if TYPE_CHECKING:
    from typing_extensions import Self

    from tracerisk.ros.messages.misfits import Misfits


class Message2:
    """A ROS 2 message: fields by keyword.

    What does not fit is an error at the assignment, or when the message is sent: `Misfits`.

    Raises:
        AssertionError: a keyword is not a field, or a value does not fit its field.
    """

    __slots__: Sequence[str] = ()
    __hash__ = None  # type: ignore[assignment]  # messages are mutable and compare by value

    _ros_type: ClassVar[str] = ""
    _ros_fields: ClassVar[tuple[Field2, ...]] = ()
    _fields_and_field_types: ClassVar[dict[str, str]] = {}
    _misfits: ClassVar[Misfits]
    SLOT_TYPES: ClassVar[tuple[Any, ...]] = ()

    def __init__(self, **kwargs: Any) -> None:
        known = self._fields_and_field_types
        checks = bool(kwargs.pop("check_fields", False)) and self._misfits.knows_check_fields
        unknown = sorted(name for name in kwargs if name not in known)
        if unknown and (checks or not self._misfits.keywords_are_ignored()):
            text = ", ".join(unknown)
            raise AssertionError(f"Invalid arguments passed to constructor: {text}")
        for field in self._ros_fields:
            if field.name not in kwargs:
                object.__setattr__(self, f"_{field.name}", field.make_default())
                continue
            value = kwargs[field.name]
            if field.is_numbers:
                value = field.pack(value)
            if checks:
                field.accept(value)
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
    """Return a copy of a message as it arrives where it is sent to, nested messages included.

    A value that does not fit its field ends the process.

    Raises:
        TypeError: a field that is a list holds what cannot be iterated.
        UnicodeEncodeError: a string holds what UTF-8 has not.
    """
    kind: Any = type(message)
    made = kind.__new__(kind)
    for field in kind._ros_fields:
        kept = _copy(message, field, getattr(message, field.name))
        object.__setattr__(made, f"_{field.name}", kept)
    return made


def _copy(message: Any, field: Field2, value: Any) -> Any:
    if isinstance(value, array.array):
        return value[:]
    if field.arrangement == "array" and field.is_numbers:
        is_whole = value.ndim == 1 and value.size >= (field.size or 0)
        if not is_whole:
            _abort(message, field, value, "PyArray_NDIM(seq_field) == 1")
        return value[: field.size].copy()
    if field.arrangement == "scalar":
        return _element(message, field, value)
    if not isinstance(value, Iterable):
        if field.is_guessed:
            return value
        raise TypeError(f"expected a sequence in '{field.name}'")
    return [_element(message, field, item) for item in value]


def _element(message: Any, field: Field2, value: Any) -> Any:
    assertion = field.unsendable(value)
    if assertion:
        _abort(message, field, value, assertion)
    is_message = field.message is not None and isinstance(value, Message2)
    return copy_message(value) if is_message else field.as_sent(value)


def _abort(message: Any, field: Field2, value: Any, assertion: str) -> NoReturn:
    # Imported here: a program that makes messages alone needs no run.
    abort_sending(type(message)._ros_type, field, value, assertion)


def _shown(value: Any) -> str:
    if isinstance(value, array.array):
        return repr(value.tolist())
    return repr(value)


def _equal(mine: Any, other: Any) -> bool:
    if isinstance(mine, np.ndarray) or isinstance(other, np.ndarray):
        return bool(np.array_equal(mine, other))
    return bool(mine == other)
