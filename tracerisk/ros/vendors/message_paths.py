"""Fields of messages by their dotted paths: checked against a class, read and written.

`angles`, `target.pose`, `joints[2]`; `points[].positions` is that of each point in turn.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from tracerisk.errors import one_of
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.messages.fields import DURATIONS, FLOATS, TIMES, MessageField, fields_of, type_of
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.vendors.conventions import Conventions, Quantity
from tracerisk.twin.physics.motion import Pose

EACH = -1
"""The index of `[]`."""
SI = Conventions(rotation="quaternion")
"""The conventions of ROS's own messages (REP 103)."""
_OF_ROS = re.compile(r"(std|geometry|sensor|trajectory|control|moveit|nav|builtin)_\w+/")
_STEP = re.compile(r"(\w+)(?:\[(\d*)\])?")


class FieldError(ValueError):
    """A path that leads to no field, with what is allowed there."""


def steps_of(path: str) -> list[tuple[str, int | None]]:
    """Return the names of a path, each with its index: None for none, `EACH` for all."""
    steps = []
    for part in path.split("."):
        name, index = _STEP.fullmatch(part).groups()  # type: ignore[union-attr]
        steps.append((name, None if index is None else int(index) if index else EACH))
    return steps


def check(message_class: Any, path: str) -> MessageField:
    """Return the field that a path leads to in a class of messages.

    Raises:
        FieldError: there is none; with the names that are allowed.
    """
    owner, field = message_class, None
    for name, index in steps_of(path):
        if owner is None:
            assert field is not None
            raise FieldError(f"'{field.name}' is {field.type_text} and has no field '{name}'")
        fields = {message_field.name: message_field for message_field in fields_of(owner)}
        if name not in fields:
            raise FieldError(f"{type_of(owner)} has no field '{name}'; {one_of(fields, name)}")
        field = fields[name]
        if index is not None and not field.is_array:
            raise FieldError(f"'{name}' of {type_of(owner)} is {field.type_text}, no list")
        if index is not None and field.length is not None and index >= field.length:
            raise FieldError(f"'{name}' of {type_of(owner)} has {field.length} entries")
        # A field of each of a list: what follows needs an index.
        owner = field.message if index is not None or not field.is_array else None
    assert field is not None
    return field


def read(message: Any, path: str) -> Any:
    """Return what a path leads to; a list where it goes through `[]`.

    Raises:
        FieldError: a list is too short.
    """
    return _read(message, steps_of(path))


def _read(value: Any, steps: Sequence[tuple[str, int | None]]) -> Any:
    for number, (name, index) in enumerate(steps):
        if not hasattr(value, name):
            raise FieldError(f"{type_of(type(value))} has no field '{name}'")
        value = getattr(value, name)
        if index == EACH:
            return [_read(item, steps[number + 1 :]) for item in value]
        if index is not None:
            if index >= len(value):
                raise FieldError(f"'{name}' has {len(value)} entries, and [{index}] is asked for")
            value = value[index]
    return value


def numbers_in(value: Any) -> list[float] | None:
    """Return the numbers of a list or of a message of numbers, None for anything else."""
    if isinstance(value, str | bytes):
        return list(value) if isinstance(value, bytes) else None
    if hasattr(value, "__len__"):
        listed = list(value)
        flat = all(not isinstance(item, str) and _is_number(item) for item in listed)
        return [float(item) for item in listed] if flat else None
    if _is_number(value):
        return [float(value)]
    if not is_message(value):
        return None
    parts = [getattr(value, field.name) for field in fields_of(type(value))]
    return [float(item) for item in parts] if parts and all(map(_is_number, parts)) else None


def content_of(value: Any) -> Any:
    """Return what the only field of a message holds, else the value itself."""
    fields = fields_of(type(value)) if is_message(value) else ()
    return getattr(value, fields[0].name) if len(fields) == 1 else value


def is_message(value: Any) -> bool:
    """Return whether a value is a message of either ROS."""
    return hasattr(value, "_ros_fields") or hasattr(value, "_slot_types")


def is_of_ros(message: Any) -> bool:
    """Return whether a message is one of ROS's own packages, whose numbers are in SI units."""
    return is_message(message) and _OF_ROS.match(type_of(type(message))) is not None


def write(message: Any, path: str, value: Any, conventions: Conventions, unit: str = "") -> None:
    """Set the field that a path leads to, as its type needs it.

    A list that a path goes through with an index, or with `[]`, becomes as long as is needed.

    Raises:
        FieldError: the value does not fit the field.
    """
    _write(message, steps_of(path), value, conventions, unit)


def _write(
    message: Any,
    steps: Sequence[tuple[str, int | None]],
    value: Any,
    conventions: Conventions,
    unit: str,
) -> None:
    (name, index), rest = steps[0], steps[1:]
    field = next(
        message_field for message_field in fields_of(type(message)) if message_field.name == name
    )
    if index is None:
        if rest:
            _write(getattr(message, name), rest, value, conventions, unit)
        else:
            set_field(message, field, value, conventions, unit)
        return
    values = _listed(value, conventions, unit) if index == EACH else [value]
    held = list(getattr(message, name))
    first = 0 if index == EACH else index
    while len(held) < first + len(values):
        held.append(_element(message, field))
    for number, item in enumerate(values, first):
        if rest:
            _write(held[number], rest, item, conventions, unit)
        else:
            held[number] = _scalar(message, field, item, conventions, unit)
    _assign(message, field, held)


def set_field(
    message: Any, field: MessageField, value: Any, conventions: Conventions, unit: str = ""
) -> None:
    """Set a field as its type needs it; raise FieldError for what does not fit."""
    if not field.is_array:
        _assign(message, field, _scalar(message, field, value, conventions, unit))
        return
    if isinstance(value, Pose) and field.message is None:
        values: list[Any] = conventions.pose_numbers(value, field.length)
    else:
        values = _listed(value, conventions, unit)
    items = [_scalar(message, field, item, conventions, unit) for item in values]
    if field.length is not None:
        items = items[: field.length]
        items += [_element(message, field) for _ in range(field.length - len(items))]
    elif field.longest is not None:
        items = items[: field.longest]
    _assign(message, field, bytes(items) if field.is_bytes else items)


def _listed(value: Any, conventions: Conventions, unit: str) -> list[Any]:
    if isinstance(value, Quantity):
        return list(conventions.numbers(value, unit))
    return list(value) if isinstance(value, list | tuple) else [value]


def _scalar(
    message: Any, field: MessageField, value: Any, conventions: Conventions, unit: str
) -> Any:
    if field.base in TIMES or field.base in DURATIONS:
        made = _element(message, field)
        number = _number(field, _plain(value, conventions, "s"))
        set_time(made, round(number * 1e9) + (EPOCH_NS if field.base in TIMES else 0))
        return made
    if field.message is not None:
        made = field.message()
        fill(made, value, conventions, unit)
        return made
    value = _plain(value, conventions, unit)
    if field.base in ("string", "wstring"):
        return value if isinstance(value, str) else str(value)
    if field.base == "bool":
        return bool(value)
    number = _number(field, value)
    if field.base in FLOATS:
        return number
    if not math.isfinite(number):
        raise FieldError(f"{value} does not fit '{field.name}', which is {field.base}")
    limits = field.integer_limits or (0, 255)
    whole = min(max(round(number), limits[0]), limits[1])
    if isinstance(value, int) and whole != value:
        raise FieldError(f"{value} does not fit '{field.name}', which is {field.base}")
    return bytes([whole]) if field.base == "byte" and field.is_ros2 else whole


def _number(field: MessageField, value: Any) -> float:
    if isinstance(value, str) or not _is_number(value):
        raise FieldError(f"'{value}' is not a number, and '{field.name}' is {field.base}")
    return float(value)


def _plain(value: Any, conventions: Conventions, unit: str) -> Any:
    if isinstance(value, Quantity):
        numbers = conventions.numbers(value, unit)
        return numbers[0] if numbers else 0.0
    return value


def fill(message: Any, value: Any, conventions: Conventions, unit: str = "") -> None:
    """Fill a message with a pose, or with numbers in the order of its fields.

    Raises:
        FieldError: it has no place for them.
    """
    inner = SI if is_of_ros(message) else conventions
    fields = {field.name: field for field in fields_of(type(message))}
    if isinstance(value, Pose):
        if "pose" in fields:
            set_field(message, fields["pose"], value, conventions)
            return
        named = {"translation": value.position, "position": value.position}
        turns = {"rotation": value.orientation, "orientation": value.orientation}
        parts = {**named, **turns}
        if any(name in fields for name in parts):
            for name, part in parts.items():
                if name in fields:
                    dimension: Any = "length" if name in named else "plain"
                    quantity = Quantity(tuple(part), (dimension,) * len(part))
                    set_field(message, fields[name], quantity, conventions)
            return
        value = inner.pose_numbers(value, len(fields))
    numbers = _listed(value, inner, "" if inner is SI else unit)
    for field, number in zip(fields.values(), numbers, strict=False):
        set_field(message, field, number, inner)


def _element(message: Any, field: MessageField) -> Any:
    if field.message is not None:
        return field.message()
    if field.base in TIMES or field.base in DURATIONS:
        return next(item for item in message._fields if item.name == field.name).scalar_default()
    if field.base in ("string", "wstring"):
        return ""
    if field.base == "bool":
        return False
    return 0.0 if field.base in FLOATS else b"\0" if field.base == "byte" else 0


def _assign(message: Any, field: MessageField, value: Any) -> None:
    try:
        setattr(message, field.name, value)
    except (AssertionError, TypeError, ValueError, OverflowError) as error:
        raise FieldError(f"'{field.name}' does not take {value!r}: {error}") from error


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) or (
        hasattr(value, "dtype") and getattr(value, "shape", None) == ()
    )
