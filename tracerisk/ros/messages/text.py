"""Messages as text: the YAML that printing a ROS 1 message shows."""

from __future__ import annotations

import json
import re
from typing import Any

from tracerisk.ros.time.rostime import Time, TVal

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.+-]*(?: [A-Za-z0-9_/.+-]+)*")
_WORDS = frozenset({"y", "n", "yes", "no", "true", "false", "on", "off", "null", "nan", "inf"})


def strify_message(
    val: Any,
    indent: str = "",
    time_offset: Time | None = None,
    current_time: Time | None = None,
    field_filter: Any = None,
    fixed_numeric_width: int | None = None,
) -> str:
    """Return a value as YAML text, as genpy prints it.

    With an `indent` the text of a message begins on a new line. `time_offset` is taken off
    every time; `field_filter(message)` gives the names of the fields to show.
    """
    rest = (time_offset, current_time, field_filter, fixed_numeric_width)
    if isinstance(val, str):
        return json.dumps(val) if val else "''"
    if isinstance(val, TVal):
        return _time_text(val, indent, time_offset, fixed_numeric_width)
    if type(val) in (list, tuple):
        return _list_text(val, indent, rest)
    if type(val) in (int, float) and fixed_numeric_width is not None:
        return _fixed_text(val, fixed_numeric_width)
    if not hasattr(val, "_slot_types"):
        return str(val)
    wanted = list(field_filter(val)) if field_filter is not None else val.__slots__
    lines = []
    for name, kind in zip(val.__slots__, val._slot_types, strict=True):
        if name not in wanted:
            continue
        value = getattr(val, name)
        if isinstance(value, str | bytes) and "uint8[" in kind:
            value = list(value) if isinstance(value, bytes) else [ord(letter) for letter in value]
        lines.append(f"{indent}{name}: {strify_message(value, '  ' + indent, *rest)}")
    text = "\n".join(lines)
    return "\n" + text if indent else text


def _time_text(val: TVal, indent: str, offset: Time | None, width: int | None) -> str:
    if offset is not None and isinstance(val, Time):
        val = val - offset
    if width is not None:
        return f"\n{indent}secs: {val.secs:{width}d}\n{indent}nsecs: {val.nsecs:{width}d}"
    return f"\n{indent}secs: {val.secs}\n{indent}nsecs: {val.nsecs:9d}"


def _list_text(val: Any, indent: str, rest: tuple[Any, ...]) -> str:
    if not val:
        return "[]"
    first = val[0]
    if isinstance(first, str):
        return "".join(f"\n{indent}- {_yaml_scalar(item)}" for item in val)
    if isinstance(first, bool) or (type(first) in (int, float) and rest[-1] is None):
        return str(list(val))
    if type(first) in (int, float):
        return "[" + ", ".join(strify_message(item, indent, *rest) for item in val) + "]"
    return "".join(f"\n{indent}- {strify_message(item, indent + '  ', *rest)}" for item in val)


def _fixed_text(val: float, width: int) -> str:
    if isinstance(val, int):
        return f"{val:{width}d}"
    text = f"{val:.{width}f}"
    return text[: max(text.find("."), width)]


def _yaml_scalar(text: str) -> str:
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    if text.isprintable():
        return "'" + text.replace("'", "''") + "'"
    return json.dumps(text)
