"""What a controller and the files around it say about the robot of a workspace."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Set
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

from tracerisk.twin.robots.robot_names import words_in

_SHORTEST_STEM = 5  # `joint` alone says nothing about the arm
_IN_MANY_NAMES = frozenset({"robot", "arm", "moveit", "gripper", "hand", "demo", "with"})
# What so many robots call a part of theirs says nothing about which one it is.
SAYS_NOTHING = frozenset({"world", "base", "base_link", "link", "tool0", "open", "close", "home"})


def words_of_one(names: Set[str]) -> frozenset[str]:
    """Return the words, between underscores, that are in one of the names alone."""
    counts = Counter(word for name in names for word in {*name.split("_")})
    return frozenset(word for word, count in counts.items() if count == 1)


def models_in(name: str) -> Set[str]:
    """Return the models in a name, as makers call them: `ur5` in `unity_ur5_demo`."""
    return set(re.findall(r"(?<![a-z0-9])[a-z]+\d+[a-z]?(?![a-z0-9])", name.lower()))


def words_shared(robot: str, stem: str) -> Set[str]:
    """Return the words of a robot's name that are in the name of a script's file."""
    words, own = (set(re.findall(r"[a-z]{4,}", name)) for name in (robot, stem))
    return (words & own) - _IN_MANY_NAMES


LaunchedBy = Literal["controller", "package", "named", "workspace"]
"""Whose launch file it is: the one that starts the controller, one of its own package, one of a
package that it names, or another one of the workspace."""


@dataclass(frozen=True, slots=True)
class LaunchedDescription:
    """The file of a robot that a launch file names, as far as it can be known."""

    path: Path | None
    """The description file; `None` where it is not known or not here."""
    arguments: tuple[tuple[str, str], ...]
    """Name and value of each argument that the launch file gives xacro."""
    problem: str
    """Why there is no `path`; empty where there is one."""
    file: str
    """The launch file, for messages."""
    by: LaunchedBy
    """The relation of the launch file to the controller."""


@dataclass(frozen=True)
class Spoken:
    """What a controller, its launch files and its manifest say about the workspace's robot."""

    strings: tuple[str, ...]
    """The strings of the controller's sources."""
    packages: frozenset[str] = frozenset()
    """The packages that they name, the controller's own among them."""
    described: tuple[LaunchedDescription, ...] = ()
    """The files of robots that launch files name, those of the controller's own first."""
    joints: tuple[str, ...] = ()
    """The joints that the controller lists."""
    own_strings: tuple[str, ...] = ()
    """The strings of the controller itself, without its modules."""
    around: str = ""
    """The names of the controller's folders, up to the top of its project."""

    @cached_property
    def words(self) -> frozenset[str]:
        """The strings and their parts."""
        return words_in(self.strings)

    @cached_property
    def own_words(self) -> frozenset[str]:
        """The strings of the controller itself, and their parts."""
        return words_in(self.own_strings)

    def other_model(self, robot: str, robots: Set[str]) -> tuple[bool, bool]:
        """Return whether the controller itself, and whether its folders, mean another model.

        That is one of the other `robots`, and no model that is in the name of this one.
        """
        own, known = models_in(robot), {model for name in robots for model in models_in(name)}
        meant = known & self.own_words, known & models_in(self.around)
        by_source, by_folder = (bool(own and named and own.isdisjoint(named)) for named in meant)
        return by_source, by_folder

    def asks_for(self, variants: Set[str]) -> bool:
        """Return whether the controller itself, and not only a library, has one of the words."""
        return bool(variants & self.own_words)

    def among(self, names: Set[str]) -> Set[str]:
        """Return those of the names that the controller names, also as a stem before a number."""
        return {
            name
            for name in names - SAYS_NOTHING
            if name in self.words
            or (
                (stem := name.rstrip("0123456789")) in self.words
                and stem != name
                and len(stem.rstrip("_")) > _SHORTEST_STEM
            )
        }

    def exactly(self, names: Iterable[str]) -> Set[str]:
        """Return those of the names that the controller names as they are."""
        return (set(names) & self.words) - SAYS_NOTHING

    def exactly_own(self, names: Iterable[str]) -> Set[str]:
        """Return those of the names that the controller itself names as they are."""
        return (set(names) & self.own_words) - SAYS_NOTHING
