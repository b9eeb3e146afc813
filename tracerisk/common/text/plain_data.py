"""Fields of values as plain data, as they are printed as JSON."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any


def picked(value: Any, *names: str) -> dict[str, Any]:
    """Return some fields or properties of a value as plain data, by their names."""
    return {name: _plain(getattr(value, name)) for name in names}


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return picked(value, *(field.name for field in fields(value)))
    if isinstance(value, (list, tuple)):
        return type(value)(map(_plain, value))
    if isinstance(value, dict):
        return {_plain(key): _plain(element) for key, element in value.items()}
    return value
