"""Which URDF an SRDF goes with, and what an SRDF adds to a robot that is known already."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from tracerisk.common.text.bounded import file_text
from tracerisk.config import PACKAGE_FILE
from tracerisk.twin.robots.prefix import with_prefix
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.urdf.groups import groups_of, states_of
from tracerisk.twin.urdf.srdf import Srdf
from tracerisk.twin.urdf.tree import tree_of
from tracerisk.twin.workspace.description_files import DescriptionFile, distance

_FITS = 0.6  # the share of an SRDF's names that its URDF must have
_XACRO_ARGUMENT = re.compile(r"(\w+):=(\S+)")


@dataclass(frozen=True, slots=True)
class SetupAssistant:
    """What MoveIt's setup assistant noted of the URDF from which it made an SRDF."""

    package: str
    """The package of the URDF."""
    relative_path: str
    """The path of the URDF in its package."""
    arguments: Mapping[str, str] = field(default_factory=dict)
    """The xacro arguments with which the URDF was read."""


def setup_assistant(srdf: Path) -> SetupAssistant | None:
    """Return what `.setup_assistant` beside an SRDF or above it says, `None` for none."""
    for folder in list(srdf.parents)[:2]:
        path = folder / ".setup_assistant"
        try:
            # A pipe would keep who reads it waiting.
            text = file_text(path, errors="replace") if path.is_file() else ""
        except OSError:
            continue
        package, relative, given = (
            re.search(rf"^\s*{key}:[ \t]*(.*)$", text, re.MULTILINE)
            for key in ("package", "relative_path", "xacro_args")
        )
        if package and relative:
            return SetupAssistant(
                package[1].strip().strip("\"'"),
                relative[1].strip().strip("\"'"),
                dict(_XACRO_ARGUMENT.findall(given[1])) if given else {},
            )
    return None


def noted_package(folder: Path) -> str | None:
    """Return the package that MoveIt's setup assistant noted in a folder; `None` for none."""
    noted = setup_assistant(folder / "config")
    return None if noted is None else noted.package


def needed_packages(srdf: Path, packages: Mapping[str, Path]) -> tuple[Path, ...]:
    """Return the folders of the packages that the manifest of an SRDF's package names."""
    own = next((package for package in packages.values() if srdf.is_relative_to(package)), None)
    if own is None:
        return ()
    try:
        text = file_text(own / PACKAGE_FILE, errors="replace")
    except OSError:
        return ()
    words = frozenset(re.findall(r">\s*([\w.-]+)\s*<", text))
    return tuple(folder for name, folder in packages.items() if name in words and folder != own)


@dataclass(frozen=True, slots=True)
class UrdfChoice:
    """How well URDF files go with an SRDF, before they are read."""

    file: DescriptionFile
    """The file of the SRDF."""
    srdf: Srdf
    """What the SRDF contains."""
    noted: SetupAssistant | None
    """What MoveIt's setup assistant noted; `None` where it left nothing."""
    packages: Mapping[str, Path]
    """The folders of the workspace's packages, by package name."""
    needed: tuple[Path, ...] = ()
    """The folders of the packages on which the SRDF's package depends."""

    def is_noted(self, urdf: DescriptionFile) -> bool:
        """Return whether MoveIt's assistant made the SRDF from the file."""
        if self.noted is None or self.noted.package not in self.packages:
            return False
        return urdf.path == self.packages[self.noted.package] / self.noted.relative_path

    def is_needed(self, urdf: DescriptionFile) -> bool:
        """Return whether a file is a robot in a package on which the one of the SRDF depends."""
        return bool(urdf.robot_name) and any(map(urdf.path.is_relative_to, self.needed))

    def arguments(self, urdf: DescriptionFile) -> Mapping[str, str] | None:
        """Return the arguments of the assistant's file, `None` for another file."""
        return self.noted.arguments if self.noted is not None and self.is_noted(urdf) else None

    def is_named(self, urdf: DescriptionFile) -> bool:
        """Return whether a file has the name of the SRDF or of its file, or made it."""
        own = {self.srdf.name, self.file.stem}
        return self.is_noted(urdf) or bool(own & {urdf.robot_name, urdf.stem})

    def is_near(self, urdf: DescriptionFile) -> bool:
        """Return whether a file is the SRDF's by its name, or has some of its joints."""
        return self.is_named(urdf) or bool(self.srdf.words & urdf.words)

    def rank(self, urdf: DescriptionFile) -> tuple[bool, bool, bool, int, int, str]:
        """Return how a file is ranked, the best one first."""
        return (
            not self.is_noted(urdf),
            self.srdf.name not in (urdf.robot_name, urdf.stem),
            self.file.stem != urdf.stem,
            -len(self.srdf.words & urdf.words),
            distance(self.file.path, urdf.path),
            urdf.shown,
        )


def has_parts_of(robot: Robot, srdf: Srdf, *, lacks_parts: bool = False) -> bool:
    """Return whether a robot has most joints and links of an SRDF's groups, and a whole group.

    Of a robot that `lacks_parts` of absent packages, such as its gripper, a group is enough. A
    gripper alone is not the robot of an SRDF that has the chain of an arm.
    """
    names: set[str] = set()
    for group in srdf.groups:
        names.update(group.joints, group.links, *group.chains)
    has = {*robot.link_names, *(one.name for one in robot.attachments)}
    if not robot.arm_joints and any(
        {*chain} - has for group in srdf.groups for chain in group.chains
    ):
        return False
    if not lacks_parts and len(names & has) < _FITS * len(names):
        return False
    return any(group.name in robot.groups for group in srdf.groups)


def shipped_with_srdf(name: str, prefix: str, srdf: Srdf) -> Robot:
    """Return a shipped robot with a prefix before its names, and the groups of an SRDF."""
    robot = load_robot(name)
    return with_srdf(with_prefix(robot, prefix) if prefix else robot, srdf)


def with_srdf(robot: Robot, srdf: Srdf) -> Robot:
    """Return a known robot with the groups and states of an SRDF beside its own."""
    joints = {joint.name: joint for joint in robot.joints}
    groups = {**robot.groups, **groups_of(tree_of(robot), srdf)}
    states = {**robot.named_states}
    for group, item in states_of(srdf, groups, joints).items():
        states[group] = MappingProxyType({**states.get(group, {}), **item})
    return replace(
        robot,
        groups=MappingProxyType(groups),
        named_states=MappingProxyType(states),
        disabled_collisions=robot.disabled_collisions | srdf.disabled_collisions,
    )
