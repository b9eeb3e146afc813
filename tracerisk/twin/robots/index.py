"""The names in the shipped robots, found at once: the files are not parsed as YAML, only scanned.

That is quick because our own files are written in one way, which a test holds them to. Whatever
more is asked of a robot is read by `load_robot`.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from tracerisk.twin.robots.robot import SHIPPED_ROBOTS, robot_names

_SECTION = re.compile(r"^(\w+):(.*)$")
_ENTRY = re.compile(r"^  - \{?name: (\S+?)(?:,|\}|$)(.*)$")
_GROUP = re.compile(r"^  (\S+):\n    joints: \[([^\]]*)\]", re.MULTILINE)
_JOINTS = re.compile(r"\bjoints: \[([^\]]*)\]")
_OF_THEIR_ARM = frozenset(
    {"gripper", "interbotix_gripper", "left_gripper", "right_gripper", "tool"}
)
"""Grippers whose names do not say which they are, or whose body is part of the arm."""


@dataclass(frozen=True, slots=True)
class RobotNames:
    """What a shipped robot calls itself and its parts, and what stands at the top of its file."""

    name: str
    """The name by which a run chooses the robot."""
    title: str
    """The maker's name of the robot, for outputs."""
    aliases: tuple[str, ...]
    """Other names by which a controller may mean the robot."""
    other_models: tuple[str, ...]
    """Words that make it another model where they stand behind the robot's name."""
    source: str
    """Where the figures of the file are from."""
    payload: float | None
    """The rated payload [kg]; `None` where the file gives none."""
    links: tuple[str, ...]
    """The names of the links."""
    joints: tuple[str, ...]
    """The names of all joints that move."""
    arm_joints: tuple[str, ...]
    """The joints that belong to no gripper."""
    groups: Mapping[str, tuple[str, ...]]
    """The joints of each planning group."""
    grippers: tuple[str, ...]
    """The names of the grippers."""
    controllers: tuple[str, ...]
    """The names of the driver's controllers."""


@functools.cache
def shipped_names() -> tuple[RobotNames, ...]:
    """Return the names in each shipped robot, in the order of the robots' names."""
    return tuple(
        scan_names((SHIPPED_ROBOTS / f"{name}.yaml").read_text(encoding="utf-8"))
        for name in robot_names()
    )


def shipped_grippers() -> dict[str, str]:
    """Return the grippers that any arm can be given, each with a shipped robot that has it."""
    grippers: dict[str, str] = {}
    for robot in shipped_names():
        for name in robot.grippers:
            if name not in _OF_THEIR_ARM:
                grippers.setdefault(name, robot.name)
    return dict(sorted(grippers.items()))


def scan_names(text: str) -> RobotNames:
    """Return the names in a robot file that is written as the shipped ones are."""
    sections = dict(_sections(text))
    grippers = sections.get("grippers", "")
    held = {
        joint.strip() for match_ in _JOINTS.finditer(grippers) for joint in match_[1].split(",")
    }
    joints = tuple(name for name, rest in _entries(sections, "joints") if "type: fixed" not in rest)
    return RobotNames(
        name=sections["name"].strip(),
        title=sections["title"].strip(),
        aliases=_list(sections.get("aliases", "")),
        other_models=_list(sections.get("other_models", "")),
        source=" ".join(sections["source"].split()).removeprefix(">- "),
        payload=float(sections["payload"]) if "payload" in sections else None,
        links=tuple(name for name, _ in _entries(sections, "links")),
        joints=joints,
        arm_joints=tuple(name for name in joints if name not in held),
        groups=MappingProxyType(
            {match_[1]: _list(match_[2]) for match_ in _GROUP.finditer(sections["groups"])}
        ),
        grippers=tuple(name for name, _ in _entries(sections, "grippers")),
        controllers=tuple(name for name, _ in _entries(sections, "controllers")),
    )


def _sections(text: str) -> Iterator[tuple[str, str]]:
    """Yield each key at the top with all that stands under it."""
    key, lines = "", list[str]()
    for line in text.splitlines():
        matched = _SECTION.match(line)
        if matched is not None:
            yield key, "\n".join(lines)
            key, lines = matched[1], [matched[2]]
        elif not line.startswith("#"):
            lines.append(line)
    yield key, "\n".join(lines)


def _entries(sections: dict[str, str], key: str) -> Iterator[tuple[str, str]]:
    for line in sections.get(key, "").splitlines():
        matched = _ENTRY.match(line)
        if matched is not None:
            yield matched[1], matched[2]


def _list(text: str) -> tuple[str, ...]:
    inner = text.strip().removeprefix("[").removesuffix("]")
    return tuple(part.strip() for part in inner.split(",") if part.strip())
