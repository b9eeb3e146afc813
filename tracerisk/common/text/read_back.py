"""Dataclasses from what `dataclasses.asdict` and JSON made of them."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from dataclasses import is_dataclass
from functools import cache
from typing import Any, TypeVar, cast

T = TypeVar("T")

_hints = cache(typing.get_type_hints)
_PLAIN = frozenset({str, int, float, bool})


def read_back(kind: type[T], data: Any) -> T:
    """Return a value of the kind; lists and maps become what its fields are declared to be.

    Raises ValueError, TypeError or AttributeError for data of another shape.
    """
    return cast(T, _read(kind, data))


def _read(kind: Any, data: Any) -> Any:
    if data is None or kind in _PLAIN:
        return data
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return _read(
            next(argument for argument in arguments if argument is not types.NoneType), data
        )
    if is_dataclass(kind):
        hints = _hints(cast(type, kind))
        return kind(**{name: _read(hints.get(name), item) for name, item in data.items()})  # type: ignore[operator]
    if origin is tuple:
        kinds = arguments[:1] * len(data) if arguments[-1] is Ellipsis else arguments
        return tuple(_read(item, value) for item, value in zip(kinds, data, strict=True))
    if origin is frozenset:
        return frozenset(_read(arguments[0], item) for item in data)
    if origin is Mapping:
        return types.MappingProxyType({key: _read(arguments[1], data[key]) for key in data})
    return data
