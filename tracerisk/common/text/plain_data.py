"""Dataclasses as plain JSON values, and back with every type checked."""

from __future__ import annotations

import json
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields, is_dataclass
from typing import Any, TypeVar, cast

from tracerisk.errors import one_of

T = TypeVar("T")


class MismatchError(Exception):
    """Plain JSON values do not fit a dataclass; `path` is the dotted path of the value."""

    def __init__(self, path: str, message: str) -> None:
        super().__init__(message)
        self.path = path
        self.message = message


def plain_data(value: Any) -> Any:
    """Return a dataclass as plain JSON values."""
    return json.loads(json.dumps(asdict(value), allow_nan=False))


def picked(value: Any, *names: str) -> dict[str, Any]:
    """Return some fields or properties of a value as plain data, by their names."""
    return {name: _plain(getattr(value, name)) for name in names}


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, (str, int, float)):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        return picked(value, *(field.name for field in fields(value)))
    if isinstance(value, (list, tuple)):
        return type(value)(map(_plain, value))
    if isinstance(value, dict):
        return {_plain(key): _plain(element) for key, element in value.items()}
    return value


def read_plain(kind: type[T], data: Any, path: str = "") -> T:
    """Return the value of a dataclass that plain JSON values state.

    Raises MismatchError where a key is missing or unknown, or a value has another type; `path` is
    what the value itself is called there.
    """
    return cast(T, _read(kind, data, path))


def _read(kind: Any, value: Any, path: str) -> Any:
    """Return `value`, plain JSON, as the annotated type `kind`."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if is_dataclass(kind):
        return _read_dataclass(cast(type, kind), value, path)
    if origin in (typing.Union, types.UnionType):
        if value is None and type(None) in arguments:
            return None
        inner = [argument for argument in arguments if argument is not type(None)]
        return _read(inner[0], value, path)
    if origin is typing.Literal:
        if value not in arguments:
            raise MismatchError(path, f"{value!r} is not allowed; {one_of(arguments, str(value))}")
        return value
    if origin is tuple:
        if not isinstance(value, list):
            raise MismatchError(path, "expected a list")
        return tuple(_read(arguments[0], item, f"{path}[{i}]") for i, item in enumerate(value))
    if origin is Mapping:
        if not isinstance(value, dict):
            raise MismatchError(path, "expected an object")
        return {name: _read(arguments[1], item, f"{path}.{name}") for name, item in value.items()}
    return _read_leaf(getattr(kind, "__supertype__", kind), value, path)


def _read_dataclass(kind: type, value: Any, path: str) -> Any:
    if not isinstance(value, dict):
        raise MismatchError(path, "expected an object")
    hints = typing.get_type_hints(kind)
    known = {field.name: field for field in fields(kind)}
    for key in value:
        if key not in known:
            raise MismatchError(path, f"unknown key '{key}'; {one_of(known, key)}")
    for name, field in known.items():
        has_default = not (field.default is MISSING and field.default_factory is MISSING)
        if name not in value and not has_default:
            raise MismatchError(path, f"key '{name}' is missing")
    prefix = f"{path}." if path else ""
    return kind(**{key: _read(hints[key], item, prefix + key) for key, item in value.items()})


def _read_leaf(kind: type, value: Any, path: str) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        try:
            value = float(value)
        except OverflowError:  # above the largest double
            raise MismatchError(path, "expected a finite number") from None
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise MismatchError(path, f"expected {kind.__name__}, found {type(value).__name__}")
    if isinstance(value, float) and not math.isfinite(value):
        raise MismatchError(path, "expected a finite number")
    return value
