"""Write a robot as JSON and read it back: what the process of a run is to simulate."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tracerisk.common.text.bounded import MOST_WRITTEN, file_text
from tracerisk.common.text.read_back import read_back
from tracerisk.twin.robots.robot import Robot


def dump_robot(robot: Robot) -> str:
    """Return a robot as JSON; equal robots give the same text."""
    # On one line: Python's own encoder, which would indent, takes ten times as long.
    return json.dumps(robot_data(robot))


def robot_data(robot: Robot) -> dict[str, Any]:
    """Return a robot as what JSON has; equal robots give equal data."""
    data: dict[str, Any] = _plain(robot)
    return data


def read_dumped_robot(path: Path) -> Robot:
    """Read what `dump_robot` wrote."""
    return read_back(Robot, json.loads(file_text(path, most=MOST_WRITTEN)))


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, str | float | int):
        return value
    if dataclasses.is_dataclass(value):
        fields = dataclasses.fields(value)
        return {field.name: _plain(getattr(value, field.name)) for field in fields}
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, frozenset):
        return sorted(_plain(item) for item in value)
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value
