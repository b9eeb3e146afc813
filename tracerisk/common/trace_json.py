"""A trace as JSON: everything the run showed, sorted, no times of day, hosts or paths."""

from __future__ import annotations

import json
import math
import sys
import types
import typing
from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields, is_dataclass
from typing import Any, cast

from tracerisk import trace as trace_module
from tracerisk.errors import Location, LogError, one_of
from tracerisk.trace import Trace, Verdict

SCHEMA = "tracerisk-trace"
VERSION = 2
"""Raised when a field is added whose absence would be read as a use that never was."""


def trace_data(trace: Trace) -> dict[str, Any]:
    """Return the trace as plain JSON values, schema and version with it."""
    return {"schema": SCHEMA, "version": VERSION, **asdict(trace)}


def plain_data(value: Any) -> Any:
    """Return a dataclass as plain JSON values."""
    return json.loads(json.dumps(asdict(value), allow_nan=False))


def verdict_of_data(data: Any) -> Verdict | None:
    """Return the verdict that plain JSON values state; `None` where they state none."""
    try:
        return cast(Verdict, _read(Verdict, data, "verdict"))
    except _MismatchError:
        return None


def dumps(trace: Trace, *, indent: int | None = 1) -> str:
    """Return the trace as JSON text, on one line without `indent`; floats read back to the bit."""
    text = json.dumps(
        trace_data(trace), indent=indent, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    return text + "\n"


def loads(text: str, file: str) -> Trace:
    """Read a trace from JSON text; `file` is its name in messages.

    Raises LogError with line and column where the text is not JSON, and with the path of the
    element where a key is missing, unknown or of the wrong type.
    """
    try:
        data = json.loads(text, parse_constant=_no_constant)
    except json.JSONDecodeError as error:
        raise LogError(
            f"is not valid JSON: {error.msg}; is the file truncated?",
            Location(file, error.lineno, error.colno),
        ) from error
    except (ValueError, RecursionError) as error:
        raise LogError(f"cannot be read: {error}", Location(file)) from error
    try:
        if not isinstance(data, dict) or data.get("schema") != SCHEMA:
            raise _MismatchError("", f"is not a trace: it has no 'schema' {SCHEMA}")
        if data.get("version") != VERSION:
            raise _MismatchError(
                "version",
                f"{data.get('version')!r}; this tracerisk reads {VERSION}: run the controller "
                "again with --trace",
            )
        body = {key: value for key, value in data.items() if key not in ("schema", "version")}
        trace = cast(Trace, _read(Trace, body, ""))
        _check(trace)
    except _MismatchError as error:
        where = f"{error.path}: " if error.path else ""
        raise LogError(f"{where}{error.message}", Location(file)) from error
    return trace


class _MismatchError(Exception):
    def __init__(self, path: str, message: str) -> None:
        super().__init__(message)
        self.path = path
        self.message = message


def _check(trace: Trace) -> None:
    known = {function.ref for function in trace.functions}
    elements = {element.name for element in trace.elements}
    for number, visit in enumerate(trace.visits):
        if visit.function not in known:
            raise _MismatchError(
                f"visits[{number}].function", f"'{visit.function.name}' is not listed"
            )
        for name in visit.exposures:
            if name not in elements:
                raise _MismatchError(
                    f"visits[{number}].exposures", f"unknown element; {one_of(elements, name)}"
                )


def _read(kind: Any, value: Any, path: str) -> Any:
    """Return `value`, plain JSON, as the annotated type `kind`."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if is_dataclass(kind):
        return _read_dataclass(cast(type, kind), value, path)
    if origin in (typing.Union, types.UnionType):
        if value is None and type(None) in arguments:
            return None
        inner = [each for each in arguments if each is not type(None)]
        return _read(inner[0], value, path)
    if origin is typing.Literal:
        if value not in arguments:
            raise _MismatchError(path, f"{value!r} is not allowed; {one_of(arguments, str(value))}")
        return value
    if origin is tuple:
        if not isinstance(value, list):
            raise _MismatchError(path, "expected a list")
        return tuple(_read(arguments[0], each, f"{path}[{i}]") for i, each in enumerate(value))
    if origin is Mapping:
        if not isinstance(value, dict):
            raise _MismatchError(path, "expected an object")
        return {name: _read(arguments[1], each, f"{path}.{name}") for name, each in value.items()}
    return _read_plain(getattr(kind, "__supertype__", kind), value, path)


def _read_dataclass(kind: type, value: Any, path: str) -> Any:
    if not isinstance(value, dict):
        raise _MismatchError(path, "expected an object")
    names = {**vars(trace_module), **vars(sys.modules[kind.__module__])}
    hints = typing.get_type_hints(kind, names)
    known = {field.name: field for field in fields(kind)}
    for key in value:
        if key not in known:
            raise _MismatchError(path, f"unknown key '{key}'; {one_of(known, key)}")
    for name, field in known.items():
        has_default = not (field.default is MISSING and field.default_factory is MISSING)
        if name not in value and not has_default:
            raise _MismatchError(path, f"key '{name}' is missing")
    prefix = f"{path}." if path else ""
    return kind(**{key: _read(hints[key], each, prefix + key) for key, each in value.items()})


def _read_plain(kind: type, value: Any, path: str) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        try:
            value = float(value)
        except OverflowError:  # above the largest double
            raise _MismatchError(path, "expected a finite number") from None
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise _MismatchError(path, f"expected {kind.__name__}, found {type(value).__name__}")
    if isinstance(value, float) and not math.isfinite(value):
        raise _MismatchError(path, "expected a finite number")
    return value


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is not a number")
