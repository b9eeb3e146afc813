"""Messages written in YAML: nested fields, arrays, constants by name, `stamp: now`, pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import Location, ScenarioError, one_of
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.messages.fields import (
    DURATIONS,
    FLOATS,
    TIMES,
    MessageField,
    constants_of,
    fields_of,
    type_of,
)
from tracerisk.ros.messages.pictures import PICTURE, picture_fields
from tracerisk.ros.time.clock import EPOCH_NS

_DRAWN = {"sensor_msgs/Image": False, "sensor_msgs/CompressedImage": True}
"""What a picture can be written for, and whether it is a file of its own."""
NOW = "now"


@dataclass(frozen=True, slots=True)
class Written:
    """A value of a YAML file and its place."""

    value: Any
    """The value, as YAML holds it."""
    file: str
    """The path of the file."""
    path: str
    """The dotted path of the value from the top of the file."""
    location: Location
    """The line of the value."""

    def key(self, key: str) -> Written:
        """Return what a mapping holds at `key`."""
        line, column = self.value.lc.key(key)
        return Written(
            self.value[key],
            self.file,
            f"{self.path}.{key}" if self.path else key,
            Location(self.file, line + 1, column + 1),
        )

    def item(self, index: int) -> Written:
        """Return the entry of a list."""
        line, column = self.value.lc.item(index)
        return Written(
            self.value[index],
            self.file,
            f"{self.path}[{index}]",
            Location(self.file, line + 1, column + 1),
        )

    def fail(self, message: str) -> NoReturn:
        """Raise ScenarioError here."""
        raise ScenarioError(f"{self.path}: {message}", self.location)


class MessageTemplate:
    """A message of a class as a file writes it; made again each time, so that `now` is now.

    Fields that are not written have the defaults of the type.

    Raises:
        ScenarioError: a field that the type lacks, or a value that does not fit, with its place.
    """

    def __init__(self, message_class: Any, written: Written | None) -> None:
        self._class = message_class
        self._written = written
        self.make(0)

    def make(self, now_ns: int) -> Any:
        """Return the message as it is at a simulated time [ns]."""
        if self._written is None:
            return self._class()
        return _message(self._class, self._written, now_ns)


def _message(message_class: Any, written: Written, now_ns: int) -> Any:
    message = message_class()
    value = written.value
    if value is None:
        return message
    fields = {field.name: field for field in fields_of(message_class)}
    if not isinstance(value, dict):
        if isinstance(value, list) and len(fields) == len(value) and _is_vector(fields.values()):
            for index, field in enumerate(fields.values()):
                setattr(message, field.name, _value(message_class, field, written.item(index), 0))
            return message
        if len(fields) == 1:
            (only,) = fields.values()
            _set(message, only, _value(message_class, only, written, now_ns), written)
            return message
        written.fail(
            f"expected a mapping of the fields of {type_of(message_class)}, found {_kind(value)}; "
            f"{one_of(fields)}"
        )
    for name in value:
        inner = written.key(name)
        if name == PICTURE and type_of(message_class) in _DRAWN:
            _draw(message, inner, [item for item in value if item in fields])
            continue
        if name not in fields:
            inner.fail(
                f"{type_of(message_class)} has no field '{name}'; {one_of(fields, str(name))}"
            )
        _set(message, fields[name], _value(message_class, fields[name], inner, now_ns), inner)
    return message


def _draw(message: Any, written: Written, others: Sequence[str]) -> None:
    """Fill the fields of a message with a picture; `others` are written beside it."""
    if not isinstance(written.value, dict):
        written.fail(f"expected a mapping, found {_kind(written.value)}")
    entry = YamlMap(written.value, written.file, written.path, ScenarioError)
    drawn = picture_fields(entry, is_png=_DRAWN[type_of(type(message))])
    twice = next((other for other in others if other in drawn), None)
    if twice is not None:
        written.fail(f"the picture gives '{twice}', which is written beside it too; leave one out")
    for name, item in drawn.items():
        setattr(message, name, item)


def _is_vector(fields: Any) -> bool:
    return all(field.base in FLOATS and not field.is_array for field in fields)


def _set(message: Any, field: MessageField, value: Any, written: Written) -> None:
    try:
        setattr(message, field.name, value)
    except AssertionError as error:
        written.fail(str(error))


def _value(owner: Any, field: MessageField, written: Written, now_ns: int) -> Any:
    if not field.is_array:
        return _scalar(owner, field, written, now_ns)
    value = written.value
    if field.is_bytes and isinstance(value, str):
        return value.encode()
    if not isinstance(value, list):
        written.fail(f"expected a list for {field.type_text}, found {_kind(value)}")
    if field.length is not None and len(value) != field.length:
        written.fail(f"expected {field.length} values for {field.type_text}, found {len(value)}")
    if field.longest is not None and len(value) > field.longest:
        written.fail(f"expected at most {field.longest} values, found {len(value)}")
    items = [_scalar(owner, field, written.item(i), now_ns) for i in range(len(value))]
    return bytes(items) if field.is_bytes else items


def _scalar(owner: Any, field: MessageField, written: Written, now_ns: int) -> Any:
    value = written.value
    if field.base in TIMES or field.base in DURATIONS:
        return _time(owner, field, written, now_ns)
    if field.message is not None:
        return _message(field.message, written, now_ns)
    if field.base == "bool":
        if not isinstance(value, bool):
            written.fail(f"expected true or false, found {_kind(value)}")
        return value
    if field.base in ("string", "wstring"):
        if not isinstance(value, str):
            written.fail(f"expected a string, found {_kind(value)}; put it in quotes")
        return str(value)
    if isinstance(value, str):
        value = _constant(owner, field, written)
    if isinstance(value, bytes):
        return value
    if field.base in FLOATS:
        if isinstance(value, bool) or not isinstance(value, int | float):
            written.fail(f"expected a number for {field.base}, found {_kind(value)}")
        return float(value)
    limits = field.integer_limits
    if isinstance(value, bool) or not isinstance(value, int) or limits is None:
        written.fail(f"expected a whole number for {field.base}, found {_kind(value)}")
    if not limits[0] <= value <= limits[1]:
        written.fail(f"{value} does not fit {field.base}; allowed: {limits[0]} to {limits[1]}")
    return bytes([value]) if field.base == "byte" and field.is_ros2 else int(value)


def _constant(owner: Any, field: MessageField, written: Written) -> Any:
    constants = {
        name: value for name, value in constants_of(owner).items() if not isinstance(value, str)
    }
    name = str(written.value)
    if name not in constants:
        known = one_of(constants, name) if constants else f"{type_of(owner)} has no constants"
        written.fail(f"expected a number for {field.base}, found {_kind(name)}; {known}")
    return constants[name]


def _time(owner: Any, field: MessageField, written: Written, now_ns: int) -> Any:
    made = _empty(owner, field)
    value = written.value
    if value == NOW and field.base in TIMES:
        set_time(made, EPOCH_NS + now_ns)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        set_time(made, round(value * 1e9))
    elif isinstance(value, dict):
        names = ("sec", "nanosec") if field.is_ros2 else ("secs", "nsecs")
        for name in value:
            part = written.key(name)
            if name not in names:
                part.fail(f"a {field.base} has no field '{name}'; {one_of(names, str(name))}")
            if isinstance(part.value, bool) or not isinstance(part.value, int):
                part.fail(f"expected a whole number, found {_kind(part.value)}")
            setattr(made, name, part.value)
    else:
        now = f"'{NOW}', " if field.base in TIMES else ""
        written.fail(f"expected {now}seconds or their parts, found {_kind(value)}")
    return made


def _empty(owner: Any, field: MessageField) -> Any:
    if field.message is not None:
        return field.message()
    return next(item for item in owner._fields if item.name == field.name).scalar_default()


def _kind(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "a list"
    return f"'{value}'"
