"""A trace as JSON: everything the run showed, sorted, no times of day, hosts or paths."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import Any

from tracerisk.common.text.digests import sha256
from tracerisk.common.text.plain_data import MismatchError, picked, read_plain
from tracerisk.common.text.printable import printable_json
from tracerisk.errors import Location, LogError, one_of
from tracerisk.trace import Trace

SCHEMA = "tracerisk-trace"
VERSION = 2
"""Raised when a field is added whose absence would be read as a use that never was."""

_PLACES = frozenset({"by", "called_from", "callers", "column", "line", "location"})
"""Keys of a trace that say where something stands in a source: comments and blocks move it."""


def trace_digest(trace: Trace) -> str:
    """Return what identifies a run: a digest of all that its trace says but lines of sources.

    The trace that is read back from its JSON has the same one.
    """
    text = json.dumps(_without_places(trace_data(trace)), sort_keys=True)
    return sha256(text.encode())


def _without_places(value: Any) -> Any:
    if isinstance(value, dict):
        kept = {key: item for key, item in value.items() if key not in _PLACES}
        return {key: _without_places(item) for key, item in kept.items()}
    if isinstance(value, list | tuple):
        return [_without_places(item) for item in value]
    # A whole number may be read back as a fraction.
    return float(value) if type(value) is int else value


def trace_data(trace: Trace) -> dict[str, Any]:
    """Return the trace as plain JSON values, schema and version with it."""
    # The replay is kept beside it, for it is no text.
    names = (field.name for field in fields(trace) if field.name != "replay")
    return {"schema": SCHEMA, "version": VERSION, **picked(trace, *names)}


def dumps(trace: Trace, *, indent: int | None = 1) -> str:
    """Return the trace as JSON text, on one line without `indent`; floats read back to the bit."""
    text = json.dumps(
        trace_data(trace), indent=indent, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    return printable_json(text) + "\n"


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
            raise MismatchError("", f"is not a trace: it has no 'schema' {SCHEMA}")
        if data.get("version") != VERSION:
            raise MismatchError(
                "version",
                f"{data.get('version')!r}; this tracerisk reads {VERSION}: `tracerisk trace "
                "FILE -o OUT.json` writes one",
            )
        body = {key: value for key, value in data.items() if key not in ("schema", "version")}
        trace = read_plain(Trace, body)
        _check(trace)
    except MismatchError as error:
        where = f"{error.path}: " if error.path else ""
        raise LogError(f"{where}{error.message}", Location(file)) from error
    return trace


def _check(trace: Trace) -> None:
    known = {function.ref for function in trace.functions}
    elements = {element.name for element in trace.elements}
    for number, visit in enumerate(trace.visits):
        if visit.function not in known:
            raise MismatchError(
                f"visits[{number}].function", f"'{visit.function.name}' is not listed"
            )
        for name in visit.exposures:
            if name not in elements:
                raise MismatchError(
                    f"visits[{number}].exposures", f"unknown element; {one_of(elements, name)}"
                )


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is not a number")
