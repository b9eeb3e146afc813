"""What is asked of a driver that nobody has described, and the fields of its request."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from tracerisk.ros.messages.fields import (
    FLOATS,
    INTEGER_BITS,
    MessageField,
    fields_of,
    snake_case,
    type_of,
)

Kind = Literal["services", "actions", "subscribed_topics"]
Found = tuple[str, dict[str, Any], str]
"""An effect of a description, its values by their roles, and both in words."""

_DEEP = 2  # levels of nested messages in which fields are looked for
_ASKS = re.compile(
    r"(^|_)(get|compute|solve|plan|ik|fk|i?kin(?!ova)\w*|inverse|forward|check|detect|find|is|query|read|convert"
    r"|transform|list|generate|calc\w*|estimate|predict|save|load|record|teach|param\w*|config\w*|limits?"
    r"|calib\w*|enable|disable|mode|state|status|register|io|payload|offset|zero|reset|clear)(_|$)"
)
_BASE = re.compile(
    r"(^|_)(base|nav\w*|wheels?|dock\w*|map|cmd_vel|camera|head|pan|tilt|lift|light)(_|$)"
)


@dataclass(frozen=True, slots=True)
class Asked:
    """An interface that nobody serves."""

    kind: Kind
    """The section of a driver's description that would serve it."""
    name: str
    """The name of the interface, such as `/arm/move`."""
    type_name: str
    """Its type, `package/Name`."""
    request: Any
    """The class of its request, goal or message."""
    elements: Mapping[str, Sequence[str]] = dataclasses.field(default_factory=dict)
    """What the source puts into lists, by the name of the field: `angle: (force, position)`."""
    lengths: Mapping[str, int] = dataclasses.field(default_factory=dict)
    """How many numbers the source puts into lists, by the name of the field."""
    largest: Mapping[str, tuple[float, bool]] = dataclasses.field(default_factory=dict)
    """The largest number that the source gives what is so called, and whether 0 is then open."""

    @property
    def called(self) -> str:
        """The words of name and type: `arm_move_joint_move_joint`; a type of ROS says nothing."""
        name = self.name.strip("/").replace("/", "_")
        short = "" if is_of_ros(self.request) else self.type_name.rpartition("/")[2]
        return snake_case(f"{name}_{short}").strip("_")


@dataclass(frozen=True, slots=True)
class Part:
    """A field of a message."""

    path: str
    """The path of the field from the top of the message, with dots."""
    field: MessageField
    """The field, with its type."""
    comment: str
    """The comment beside its definition; empty where there is none."""

    @property
    def name(self) -> str:
        """The field's name in small letters."""
        return self.field.name.lower()

    @property
    def words(self) -> str:
        """What names the unit: the field's name and its comment."""
        return f"{self.name} {self.comment.lower()}"

    @property
    def is_word(self) -> bool:
        """Whether the field holds one text."""
        return self.field.base == "string" and not self.field.is_array

    @property
    def is_number(self) -> bool:
        """Whether the field holds one number."""
        is_one = not self.field.is_array
        return is_one and (self.field.base in FLOATS or self.field.base in INTEGER_BITS)


def parts_of(message: Any, comments: Mapping[str, str], path: str = "", deep: int = _DEEP) -> (
    Iterator[Part]
):  # fmt: skip
    """Yield the fields of a message, those of nested ones with their paths; ROS's own are whole."""
    for field in fields_of(message):
        here = f"{path}{field.name}"
        is_plain = field.message is None or field.is_array or is_of_ros(field.message)
        if is_plain or deep == 0:
            yield Part(here, field, comments.get(field.name, ""))
        else:
            yield from parts_of(field.message, {}, f"{here}.", deep - 1)


def is_of_ros(message: Any) -> bool:
    """Return whether a message is one of ROS's own packages."""
    package = type_of(message).partition("/")[0]
    return package in ("geometry_msgs", "sensor_msgs", "trajectory_msgs", "std_msgs")


def is_of_others(called: str) -> bool:
    """Return whether a name is of what is asked of a driver, or of another part of the robot."""
    is_asked = _ASKS.search(called) is not None and "execute" not in called
    return is_asked or _BASE.search(called) is not None


def is_percent(part: Part) -> bool:
    """Return whether a number is in percent, as its name or comment says."""
    return bool(re.search(r"percent|override|%|0\s*(-|to|\.\.)\s*100\b", part.words))
