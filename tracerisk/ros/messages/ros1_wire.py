"""ROS 1's wire format: little endian, no padding, a uint32 length before what varies."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tracerisk.ros.messages.ros1_base import Field, Message

WRITE_FAILURES = (struct.error, TypeError, AttributeError, ValueError, OverflowError)
"""What a value of the wrong type raises while it is written."""

_CODES = {
    "bool": "B",
    "byte": "b",
    "int8": "b",
    "char": "B",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
_LENGTH = struct.Struct("<I")


def encode(message: Message) -> bytes:
    """Return the message's bytes.

    Nested fields are read by name, not by class, as genpy's generated code does: a Point
    where a Vector3 should be is written.

    Raises:
        any of WRITE_FAILURES: a value does not fit its field.
    """
    out = bytearray()
    _write_message(out, message, message._fields)
    return bytes(out)


def _write_message(out: bytearray, message: Any, fields: tuple[Field, ...]) -> None:
    for field in fields:
        _write_field(out, field, getattr(message, field.name))


def _write_field(out: bytearray, field: Field, value: Any) -> None:
    if not field.is_array:
        _write_scalar(out, field, value)
        return
    count = len(value)
    if field.length is None:
        out += _LENGTH.pack(count)
    elif count != field.length:
        raise struct.error(f"{field.length} elements wanted in {field.name}, {count} given")
    code = _CODES.get(field.base)
    if field.is_bytes and isinstance(value, bytes | bytearray):
        out += value
    elif code is not None and isinstance(value, str | bytes):
        raise TypeError(f"{field.name} is an array of numbers")
    elif code is not None:
        out += struct.pack(f"<{count}{code}", *value)
    else:
        for item in value:
            _write_scalar(out, field, item)


def _write_scalar(out: bytearray, field: Field, value: Any) -> None:
    if field.message is not None:
        _write_message(out, value, field.message._fields)
    elif field.base == "string":
        data = value if isinstance(value, bytes) else str.encode(value)
        out += _LENGTH.pack(len(data))
        out += data
    elif field.base == "time":
        out += struct.pack("<2I", value.secs, value.nsecs)
    elif field.base == "duration":
        out += struct.pack("<2i", value.secs, value.nsecs)
    else:
        out += struct.pack(f"<{_CODES[field.base]}", value)


def decode(message: Message, data: bytes, numpy: Any = None) -> None:
    """Set a message's fields from bytes.

    Arrays of numbers become tuples, as genpy's do, or arrays of `numpy` where it is given.

    Raises:
        struct.error: the bytes end before the message does.
    """
    _read_message(message, data, 0, numpy)


def _read_message(message: Message, data: bytes, at: int, numpy: Any) -> int:
    for field in message._fields:
        value, at = _read_field(field, data, at, numpy)
        setattr(message, field.name, value)
    return at


def _read_field(field: Field, data: bytes, at: int, numpy: Any) -> tuple[Any, int]:
    if not field.is_array:
        return _read_scalar(field, data, at, numpy)
    count, at = (field.length, at) if field.length is not None else _read_length(data, at)
    code = _CODES.get(field.base)
    if code is None:
        items = []
        for _ in range(count):
            item, at = _read_scalar(field, data, at, numpy)
            items.append(item)
        return items, at
    layout = f"<{count}s" if field.is_bytes else f"<{count}{code}"
    values = struct.unpack_from(layout, data, at)
    end = at + struct.calcsize(layout)
    if field.is_bytes:
        return values[0], end
    if field.base == "bool":
        return [bool(value) for value in values], end
    return (values if numpy is None else numpy.array(values, dtype=code)), end


def _read_scalar(field: Field, data: bytes, at: int, numpy: Any) -> tuple[Any, int]:
    if field.message is not None:
        nested = field.message()
        return nested, _read_message(nested, data, at, numpy)
    if field.base == "string":
        size, at = _read_length(data, at)
        (raw,) = struct.unpack_from(f"<{size}s", data, at)
        return raw.decode("utf-8", "replace"), at + size
    if field.base in ("time", "duration"):
        value = field.scalar_default()
        value.set(*struct.unpack_from("<2I" if field.base == "time" else "<2i", data, at))
        value.canon()
        return value, at + 8
    layout = "<" + _CODES[field.base]
    (number,) = struct.unpack_from(layout, data, at)
    return (bool(number) if field.base == "bool" else number), at + struct.calcsize(layout)


def _read_length(data: bytes, at: int) -> tuple[int, int]:
    return _LENGTH.unpack_from(data, at)[0], at + _LENGTH.size
