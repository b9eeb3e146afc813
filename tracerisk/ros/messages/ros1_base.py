"""The base of every ROS 1 message class, its errors and its type check."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from tracerisk.ros.messages.ros1_wire import WRITE_FAILURES, decode, encode
from tracerisk.ros.messages.text import strify_message
from tracerisk.ros.time.rostime import Duration, Time

if TYPE_CHECKING:
    from typing_extensions import Self

SIGNED_BITS = {"byte": 8, "int8": 8, "int16": 16, "int32": 32, "int64": 64}
UNSIGNED_BITS = {"char": 8, "uint8": 8, "uint16": 16, "uint32": 32, "uint64": 64}
FLOATS = frozenset({"float32", "float64"})
BYTE_TYPES = frozenset({"char", "uint8"})
PRIMITIVES = FLOATS.union(SIGNED_BITS, UNSIGNED_BITS, ("bool", "string", "time", "duration"))


class MessageException(Exception):  # noqa: N818 - the name that controllers catch
    """Base of the errors of messages."""


class SerializationError(MessageException):
    """A message holds what its fields cannot take."""


class DeserializationError(MessageException):
    """Bytes are not a message of the type they should be."""


class _Writer(Protocol):
    def write(self, data: bytes, /) -> object: ...


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message."""

    name: str
    """The name of the field."""
    base: str
    """The type without its array part."""
    is_array: bool
    """Whether it is an array."""
    length: int | None
    """The length of a fixed array; `None` for all others."""
    message: type[Message] | None
    """The class of a nested message; `None` for primitives."""

    @property
    def type_text(self) -> str:
        """The type as the message text has it: `float64[36]`."""
        if not self.is_array:
            return self.base
        return f"{self.base}[{'' if self.length is None else self.length}]"

    @property
    def is_bytes(self) -> bool:
        """Whether the value is a `bytes`, as genpy makes of uint8[] and char[]."""
        return self.is_array and self.base in BYTE_TYPES

    def default(self) -> Any:
        """Make the field's default value: zero, empty, or a nested default message."""
        if self.is_bytes:
            return b"\0" * (self.length or 0)
        if self.is_array:
            return [self.scalar_default() for _ in range(self.length or 0)]
        return self.scalar_default()

    def scalar_default(self) -> Any:
        """Make the default value of the field, or of one item of an array."""
        if self.message is not None:
            return self.message()
        if self.base in FLOATS:
            return 0.0
        if self.base == "bool":
            return False
        if self.base == "string":
            return ""
        if self.base == "time":
            return Time()
        return Duration() if self.base == "duration" else 0


class Message:
    """A ROS 1 message: one slot a field, made with all values, with keywords or with none.

    Raises:
        TypeError: both positional and keyword arguments, or too few or too many values.
        AttributeError: a keyword names no field.
    """

    __slots__ = ["_connection_header"]
    __hash__ = None  # type: ignore[assignment]  # messages are mutable and compare by value

    _type: ClassVar[str] = ""
    _slot_types: ClassVar[list[str]] = []
    _fields: ClassVar[tuple[Field, ...]] = ()
    _has_header: ClassVar[bool] = False

    def __init__(self, *args: Any, **kwds: Any) -> None:
        fields = self._fields
        if args and kwds:
            raise TypeError("Message constructor may only use args OR keywords, not both")
        if args and len(args) != len(fields):
            raise TypeError(
                f"Invalid number of arguments, args should be {self.__slots__} args are{args}"
            )
        for name in kwds:
            if name not in self.__slots__:
                raise AttributeError(f"{name} is not an attribute of {type(self).__name__}")
        given = dict(zip(self.__slots__, args, strict=True)) if args else kwds
        for field in fields:
            value = given.get(field.name)
            setattr(self, field.name, field.default() if value is None else value)

    def serialize(self, buff: _Writer) -> None:
        """Write the message to `buff` in ROS 1's wire format.

        Raises:
            SerializationError: a field holds a value of the wrong type or out of range.
        """
        try:
            data = encode(self)
        except WRITE_FAILURES as error:
            self._check_types(error)
            raise  # not reached: _check_types raises for an error
        if data:
            buff.write(data)

    def serialize_numpy(self, buff: _Writer, numpy: object) -> None:
        """Write the message to `buff`; arrays of numpy are taken as lists are."""
        del numpy
        self.serialize(buff)

    def deserialize(self, str: bytes) -> Self:  # noqa: A002 - genpy's keyword
        """Set the fields from bytes in ROS 1's wire format and return the message.

        Raises:
            DeserializationError: the bytes are too short.
        """
        return self.deserialize_numpy(str, None)

    def deserialize_numpy(self, str: bytes, numpy: Any) -> Self:  # noqa: A002 - genpy's keyword
        """Set the fields from bytes; arrays of numbers become arrays of `numpy`.

        Raises:
            DeserializationError: the bytes are too short.
        """
        try:
            decode(self, str, numpy)
        except struct.error as error:
            raise DeserializationError(f"{error}") from error
        return self

    def _get_types(self) -> list[str]:
        return self._slot_types

    def _check_types(self, exc: BaseException | None = None) -> None:
        for field in self._fields:
            check_field(field.name, field, getattr(self, field.name))
        if exc is not None:
            raise SerializationError(str(exc)) from exc

    def __getstate__(self) -> list[Any]:
        return [getattr(self, name) for name in self.__slots__]

    def __setstate__(self, state: list[Any]) -> None:
        for name, value in zip(self.__slots__, state, strict=True):
            setattr(self, name, value)

    def __repr__(self) -> str:
        return strify_message(self)

    def __str__(self) -> str:
        return strify_message(self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return False
        for name in self.__slots__:
            mine, theirs = getattr(self, name), getattr(other, name)
            if isinstance(mine, list | tuple) and isinstance(theirs, list | tuple):
                if tuple(mine) != tuple(theirs):
                    return False
            elif not mine == theirs:
                return False
        return True


def copy_message(message: Message) -> Any:
    """Return a copy of a message that came over the wire, nested messages included."""
    made = type(message).__new__(type(message))
    for field in message._fields:
        setattr(made, field.name, _copied(getattr(message, field.name)))
    return made


def _copied(value: Any) -> Any:
    if isinstance(value, list):
        return [_copied(item) for item in value]
    if isinstance(value, Message):
        return copy_message(value)
    # All that else comes over the wire cannot be changed.
    return type(value)(value.secs, value.nsecs) if isinstance(value, Time | Duration) else value


def check_field(name: str, field: Field, value: Any) -> None:
    """Check a value against a field, down to the last nested message.

    Raises:
        SerializationError: the first value that does not fit, with its dotted name.
    """
    if field.is_array:
        if isinstance(value, bytes | str):
            if field.base not in BYTE_TYPES:
                raise SerializationError(
                    f"field {name} must be a list or tuple type. Only uint8[] can be a string"
                )
            return
        if type(value) not in (list, tuple):
            raise SerializationError(f"field {name} must be a list or tuple type")
        for item in value:
            _check_scalar(f"{name}[]", field, item)
        if field.length is not None and len(value) != field.length:
            raise SerializationError(
                f"field {name} must have {field.length} elements instead of {len(value)}"
            )
    else:
        _check_scalar(name, field, value)


def _check_scalar(name: str, field: Field, value: Any) -> None:
    base = field.base
    if field.message is not None:
        _check_nested(name, field.message, value)
    elif base in SIGNED_BITS:
        if type(value) is not int:
            raise SerializationError(f"field {name} must be an integer type")
        limit = 1 << (SIGNED_BITS[base] - 1)
        if not -limit <= value < limit:
            raise SerializationError(f"field {name} exceeds specified width [{base}]")
    elif base in UNSIGNED_BITS:
        if type(value) is not int or value < 0:
            raise SerializationError(f"field {name} must be unsigned integer type")
        if value >= 1 << UNSIGNED_BITS[base]:
            raise SerializationError(f"field {name} exceeds specified width [{base}]")
    elif base in FLOATS:
        if not _is_number(value):
            raise SerializationError(f"field {name} must be float type")
    elif base == "bool":
        if value not in (True, False):
            raise SerializationError(f"field {name} is not a bool")
    elif base == "string":
        if not isinstance(value, str | bytes):
            raise SerializationError(f"field {name} must be of type bytes or an ascii string")
    elif base == "time":
        if not isinstance(value, Time):
            raise SerializationError(f"field {name} must be of type Time")
    elif not isinstance(value, Duration):
        raise SerializationError(f"field {name} must be of type Duration")


def _check_nested(name: str, expected: type[Message], value: Any) -> None:
    if not isinstance(value, Message):
        # What a stand-in returned in a newer form is sent as the message that it holds.
        value = getattr(value, "held_message", None)
    if not isinstance(value, Message):
        raise SerializationError(f"field {name} must be of type [{expected._type}]")
    if value._type == "std_msgs/Header" != expected._type:
        raise SerializationError(f"field {name} must be a Header instead of a {value._type}")
    if value._type != expected._type:
        raise SerializationError(
            f"field {name} must be of type {expected._type} instead of {value._type}"
        )
    for field in value._fields:
        check_field(f"{name}.{field.name}", field, getattr(value, field.name))


def _is_number(value: Any) -> bool:
    # The scalars of numpy are no subclass of float below 64 bits; they all offer __float__.
    return not isinstance(value, str | bytes) and hasattr(value, "__float__")
