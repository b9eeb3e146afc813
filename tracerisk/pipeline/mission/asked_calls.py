"""The calls and messages that conditions of `success` ask about by their fields or order."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import Recording
from tracerisk.ros.scenario.success import Condition
from tracerisk.ros.time.scheduler import Scheduler

_CALL = "asked_call"


@dataclass(frozen=True, slots=True)
class AskedCall:
    """One call, goal or message that a condition asks about."""

    name: str
    """The full name of the service, action or topic."""
    time_s: float
    """When it was sent [s]."""
    fields: Mapping[str, Any]
    """The values of the fields that conditions name, by their dotted paths."""
    lacks: Mapping[str, Sequence[str]]
    """Paths that the message has no field for, each with the fields that there are."""


class AskedCalls:
    """Notes into the recording what is sent to the names that conditions ask about."""

    def __init__(
        self, recorder: Recorder, scheduler: Scheduler, success: Iterable[Condition]
    ) -> None:
        self._recorder = recorder
        self._scheduler = scheduler
        self._paths: dict[str, set[str]] = {}
        for condition in success:
            for part in condition.steps or (condition,):
                if part.kind in ("called", "sent") and (part.fields or condition.steps):
                    self._paths.setdefault(part.name, set()).update(part.fields)

    def take(self, name: str, message: Any) -> None:
        """Note a call, goal or message, if a condition asks about it."""
        paths = self._paths.get(name)
        if paths is None:
            return
        fields: dict[str, Any] = {}
        lacks: dict[str, list[str]] = {}
        for path in sorted(paths):
            _put_field(message, path, fields, lacks)
        now_ns = self._scheduler.now_ns
        self._recorder.note(_CALL, name=name, ns=now_ns, fields=fields, lacks=lacks)


def asked_calls(recording: Recording) -> tuple[AskedCall, ...]:
    """Return the noted calls of a run, each later than the one before: their order is known."""
    s: list[AskedCall] = []
    for note in recording.notes:
        if note.kind == _CALL:
            time_s = note.data["ns"] / 1e9
            if s and time_s <= s[-1].time_s:
                time_s = math.nextafter(s[-1].time_s, math.inf)
            name, fields, lacks = note.data["name"], note.data["fields"], note.data["lacks"]
            s.append(AskedCall(name, time_s, fields, lacks))
    return tuple(s)


def _put_field(
    message: Any, path: str, fields: dict[str, Any], lacks: dict[str, list[str]]
) -> None:
    value = message
    for name in path.split("."):
        known = _names(value)
        if isinstance(value, list | tuple) and name.isdecimal() and int(name) < len(value):
            value = value[int(name)]
        elif name in known:
            value = getattr(value, name)
        else:
            lacks[path] = known
            return
    fields[path] = _plain(value)


def _names(message: Any) -> list[str]:
    """Return the fields of a message of either ROS."""
    if hasattr(message, "get_fields_and_field_types"):
        return sorted(message.get_fields_and_field_types())
    return sorted(name for name in getattr(message, "__slots__", ()) if not name.startswith("_"))


def _plain(value: Any) -> Any:
    """Return a value as JSON has it; a nested message as its text."""
    if isinstance(value, bool | int | str) or value is None:
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, bytes):
        return list(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if hasattr(value, "__iter__"):
        return [_plain(item) for item in value]
    return str(value)
