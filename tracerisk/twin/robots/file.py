"""Write a robot as JSON and read it back: what the process of a run is to simulate."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from tracerisk.geometry.shapes import Shape
from tracerisk.twin.robots.robot import (
    Attachment,
    Controller,
    Gripper,
    Group,
    Joint,
    Link,
    Robot,
    Scaling,
    Servo,
)
from tracerisk.twin.robots.sensors import Sensor


def dump_robot(robot: Robot) -> str:
    """Return a robot as JSON; equal robots give the same text."""
    return json.dumps(_plain(robot), indent=1)


def read_dumped_robot(path: Path) -> Robot:
    """Read what `dump_robot` wrote."""
    data = json.loads(path.read_text(encoding="utf-8"))
    scaling = data["default_scaling"]
    return Robot(
        **{
            **data,
            "links": tuple(_link(each) for each in data["links"]),
            "attachments": tuple(Attachment(**_tuples(each)) for each in data["attachments"]),
            "joints": tuple(
                Joint(**{**each, "servo": Servo(**each["servo"])}) for each in data["joints"]
            ),
            "groups": MappingProxyType(
                {name: Group(**_tuples(each)) for name, each in data["groups"].items()}
            ),
            "named_states": MappingProxyType(
                {
                    group: MappingProxyType(
                        {name: MappingProxyType(state) for name, state in states.items()}
                    )
                    for group, states in data["named_states"].items()
                }
            ),
            "initial_state": MappingProxyType(data["initial_state"]),
            "grippers": tuple(Gripper(**_tuples(each)) for each in data["grippers"]),
            "controllers": tuple(Controller(**_tuples(each)) for each in data["controllers"]),
            "default_scaling": Scaling(**scaling),
            "aliases": tuple(data["aliases"]),
            "disabled_collisions": frozenset(
                (one, other) for one, other in data["disabled_collisions"]
            ),
            "own_sensors": tuple(Sensor(**_tuples(each)) for each in data["own_sensors"]),
            "without_encoder": tuple(data["without_encoder"]),
            "actuators": MappingProxyType(_tuples(data["actuators"])),
        }
    )


def _link(data: dict[str, Any]) -> Link:
    shapes = tuple(Shape(**_tuples(each)) for each in data["shapes"])
    return Link(**{**_tuples(data), "shapes": shapes})


def _tuples(data: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(v) if isinstance(v, list) else v for key, v in data.items()}


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        fields = dataclasses.fields(value)
        return {field.name: _plain(getattr(value, field.name)) for field in fields}
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, frozenset):
        return sorted(_plain(each) for each in value)
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return value
