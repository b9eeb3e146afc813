"""Messages as dictionaries, YAML and comma-separated values."""

from __future__ import annotations

import array
import io
import sys
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

import numpy as np

_MANY = (list, tuple, array.array, np.ndarray)


@dataclass(frozen=True)
class _Shown:
    """How much of a message is shown."""

    longest: int | None
    """The greatest length of a text or array before it is cut; `None`: any."""
    no_arr: bool
    """Whether arrays are shown by type and length only."""
    no_str: bool
    """Whether texts are shown by length only."""


def message_to_ordereddict(
    msg: Any, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> OrderedDict[str, Any]:
    """Return a message's fields by name, in their order; nested messages too."""
    return _as_dict(msg, _Shown(truncate_length, no_arr, no_str))


def message_to_yaml(
    msg: Any,
    *,
    truncate_length: int | None = None,
    no_arr: bool = False,
    no_str: bool = False,
    flow_style: bool = False,
) -> str:
    """Return a message as YAML, in block style or flow style."""
    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = flow_style
    yaml.allow_unicode = True
    yaml.width = sys.maxsize
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    out = io.StringIO()
    yaml.dump(_plain(_as_dict(msg, _Shown(truncate_length, no_arr, no_str))), out)
    return out.getvalue()


def message_to_csv(
    msg: Any, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> str:
    """Return the values of a message, with commas between them."""
    return _as_csv(msg, _Shown(truncate_length, no_arr, no_str))


def _as_dict(msg: Any, shown: _Shown) -> OrderedDict[str, Any]:
    return OrderedDict(
        (field.name, _value(getattr(msg, field.name), shown, field)) for field in msg._ros_fields
    )


def _value(value: Any, shown: _Shown, field: Any = None) -> Any:
    if isinstance(value, bytes):
        text = value.decode("latin-1")
        return text if not _is_long(value, shown) else text[: shown.longest] + "..."
    if isinstance(value, str):
        if shown.no_str:
            return f"<string length: <{len(value)}>>"
        return value if not _is_long(value, shown) else value[: shown.longest] + "..."
    if isinstance(value, _MANY):
        if shown.no_arr and field is not None:
            return _abbreviated(value, field)
        kind = tuple if isinstance(value, tuple) else list
        result = [_value(item, shown) for item in value[: shown.longest]]
        return kind([*result, "..."] if _is_long(value, shown) else result)
    if isinstance(value, np.number):
        return value.item()
    if isinstance(value, bool | int | float):
        return value
    return _as_dict(value, shown)


def _as_csv(msg: Any, shown: _Shown) -> str:
    return ",".join(_csv(getattr(msg, field.name), shown, field) for field in msg._ros_fields)


def _csv(value: Any, shown: _Shown, field: Any = None) -> str:
    if isinstance(value, _MANY):
        if shown.no_arr and field is not None:
            return _abbreviated(value, field)
        parts = [_csv(item, shown) for item in value[: shown.longest]]
        return ",".join([*parts, "..."] if _is_long(value, shown) else parts)
    if isinstance(value, str) and shown.no_str:
        return f"<string length: <{len(value)}>>"
    if isinstance(value, bytes) and _is_long(value, shown):
        return str(value[: shown.longest] + b"...")
    if isinstance(value, str) and _is_long(value, shown):
        return value[: shown.longest] + "..."
    if isinstance(value, bytes | str | bool | int | float | np.number):
        return str(value)
    return _as_csv(value, shown)


def _is_long(value: Any, shown: _Shown) -> bool:
    return shown.longest is not None and len(value) > shown.longest


def _abbreviated(value: Any, field: Any) -> str:
    names = {"float32": "float", "float64": "double", "bool": "boolean", "byte": "octet"}
    element = names.get(field.base, field.base)
    if field.message is not None:
        element = field.base.replace("/", "/msg/", 1)
    if field.arrangement == "array":
        return f"<array type: {element}[{field.size}]>"
    bound = "" if field.size is None else f"[{field.size}]"
    return f"<sequence type: {element}{bound}, length: {len(value)}>"


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value
