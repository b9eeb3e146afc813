"""Setting a message's fields from a dictionary."""

from __future__ import annotations

import array
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

Setter = Callable[[Any], None]


def set_message_fields(
    msg: Any, values: Any, expand_header_auto: bool = False, expand_time_now: bool = False
) -> list[Setter]:
    """Set fields by their names, those of nested messages by dictionaries of their own.

    With `expand_header_auto` the header `auto`, and with `expand_time_now` the time `now`, give
    a function that sets the stamp; those functions are returned.

    Raises:
        AttributeError: the message has no such field.
        TypeError: a value does not fit its field.
    """
    setters: list[Setter] = []
    _set(msg, values, setters, expand_header_auto, expand_time_now)
    return setters


def _set(msg: Any, values: Any, setters: list[Setter], auto: bool, now: bool) -> None:
    if not hasattr(values, "items"):
        raise TypeError(
            f"Value '{values}' is expected to be a dictionary but is a {type(values).__name__}"
        )
    fields = {field.name: field for field in msg._ros_fields}
    for name, given in values.items():
        present = getattr(msg, name)
        kind = type(present)
        if getattr(kind, "_ros_type", "") == "std_msgs/Header" and given == "auto" and auto:
            setters.append(partial(setattr, present, "stamp"))
            continue
        if getattr(kind, "_ros_type", "") == "builtin_interfaces/Time" and given == "now" and now:
            setters.append(partial(setattr, msg, name))
            continue
        field = fields[name]
        if kind is array.array:
            value: Any = array.array(present.typecode, given)
        elif kind is np.ndarray:
            value = np.array(given, dtype=present.dtype)
        elif type(given) is kind:
            value = list(given) if field.message is not None and kind is list else given
        elif field.message is not None and field.arrangement == "scalar":
            value = kind()
            _set(value, given, setters, auto, now)
        else:
            value = kind(given)
        if field.message is not None and field.arrangement != "scalar":
            for index, item in enumerate(value):
                nested = field.message()
                _set(nested, item, setters, auto, now)
                value[index] = nested
        setattr(msg, name, value)
