"""ROS 2's wire format: CDR of version 1, little endian, each value aligned to its size.

Source: OMG DDS-XTypes 1.3, 7.4 (plain CDR, encapsulation CDR_LE); checked against rosbags.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

from tracerisk.ros.messages.ros2_fields import TYPE_CODES

if TYPE_CHECKING:
    from tracerisk.ros.messages.ros2_base import Message2
    from tracerisk.ros.messages.ros2_fields import Field2

_HEADER = b"\x00\x01\x00\x00"
_NO_FIELDS = b"\x00"
"""A structure needs at least one member: an empty message has one octet."""


def encode(message: Message2) -> bytes:
    """Return the bytes of a message, with their encapsulation header."""
    out = bytearray()
    _write_message(out, message)
    return _HEADER + bytes(out)


def decode(data: bytes, message_type: type[Message2]) -> Message2:
    """Return the message of bytes.

    Raises:
        ValueError: the header is not that of plain CDR, or the bytes end before the message.
    """
    if len(data) < len(_HEADER) or data[0] != 0 or data[1] > 1:
        raise ValueError("the data do not begin with an encapsulation header of plain CDR")
    reader = _Reader(memoryview(data)[len(_HEADER) :], "<" if data[1] else ">")
    try:
        return reader.message(message_type)
    except struct.error as error:
        raise ValueError(f"the data end before the {message_type.__name__} does") from error


def _write_message(out: bytearray, message: Any) -> None:
    fields = type(message)._ros_fields
    if not fields:
        out += _NO_FIELDS
    for field in fields:
        value = getattr(message, field.name)
        if field.arrangement == "scalar":
            _write_one(out, field, value)
            continue
        if field.arrangement == "sequence":
            _write_number(out, "I", len(value))
        if field.is_numbers and len(value):
            # At once: a picture has a million of them.
            code = _code(field.base)
            out += b"\0" * (-len(out) % struct.calcsize(code))
            out += struct.pack(f"<{len(value)}{code}", *value)
            continue
        for item in value:
            _write_one(out, field, item)


def _write_one(out: bytearray, field: Field2, value: Any) -> None:
    if field.message is not None:
        _write_message(out, value)
    elif field.base == "string":
        text = str(value).encode() + b"\0"
        _write_number(out, "I", len(text))
        out += text
    elif field.base == "byte":
        out += bytes(value)
    else:
        _write_number(out, _code(field.base), value)


def _write_number(out: bytearray, code: str, value: Any) -> None:
    size = struct.calcsize(code)
    out += b"\0" * (-len(out) % size)
    out += struct.pack("<" + code, value)


def _code(base: str) -> str:
    if base == "bool":
        return "?"
    if base not in TYPE_CODES:
        raise NotImplementedError(f"fields of type {base} cannot be serialized")
    return TYPE_CODES[base]


class _Reader:
    def __init__(self, data: memoryview, order: str) -> None:
        self._data = data
        self._order = order
        self._at = 0

    def message(self, kind: type[Message2]) -> Message2:
        made = kind()
        if not kind._ros_fields:
            self._at += len(_NO_FIELDS)
        for field in kind._ros_fields:
            setattr(made, field.name, self._field(field))
        return made

    def _field(self, field: Field2) -> Any:
        if field.arrangement == "scalar":
            return self._one(field)
        count = field.size if field.arrangement == "array" else self._number("I")
        if field.is_numbers and count:
            code = _code(field.base)
            size = struct.calcsize(code)
            self._at += -self._at % size
            return field.pack(
                struct.unpack(f"{self._order}{count}{code}", self._take(count * size))
            )
        values = [self._one(field) for _ in range(count or 0)]
        return field.pack(values) if field.is_numbers else values

    def _one(self, field: Field2) -> Any:
        if field.message is not None:
            return self.message(field.message)
        if field.base == "string":
            size = self._number("I")
            return self._take(size)[:-1].decode("utf-8", "replace")
        if field.base == "byte":
            return self._take(1)
        return self._number(_code(field.base))

    def _number(self, code: str) -> Any:
        size = struct.calcsize(code)
        self._at += -self._at % size
        return struct.unpack(self._order + code, self._take(size))[0]

    def _take(self, size: int) -> bytes:
        taken = bytes(self._data[self._at : self._at + size])
        if len(taken) < size:
            raise struct.error("no more data")
        self._at += size
        return taken
