"""What is read of launch files: the nodes that they start, and what they give to each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tracerisk.pipeline.launch_files.robot_sources import RobotSource
from tracerisk.ros.graph.parameter_files import EVERY_NODE, Parameter
from tracerisk.trace import NOT_THERE

__all__ = [
    "EVERY_NODE",
    "LaunchParameter",
    "LaunchReading",
    "LaunchSetup",
    "RobotSource",
    "StartedNode",
    "split_arguments",
]

LaunchParameter = Parameter
"""A parameter: of ROS 2 that of a node (`/**`: of all); of ROS 1 its global name, node None."""

Kind = Literal["launch", "parameters"]
"""What a setup was read from: a launch file, or a parameter file that names the node."""


@dataclass(frozen=True, slots=True)
class StartedNode:
    """A program that a launch file starts."""

    package: str
    """The package of the program; empty where it is started by `command`."""
    executable: str
    """The name of the executable; empty where it is started by `command`."""
    name: str | None = None
    """The name that the node gets; `None` for its own."""
    namespace: str = ""
    """The namespace that the node gets; empty for the root."""
    command: tuple[str, ...] = ()
    """The words of the command line that starts it; empty for a node of a package."""
    arguments: tuple[str, ...] = ()
    """The arguments of the command line, without those of ROS."""
    ros_arguments: tuple[str, ...] = ()
    """The arguments after `--ros-args`."""
    parameters: tuple[LaunchParameter, ...] = ()
    """The parameters that the node gets."""
    remaps: tuple[tuple[str, str], ...] = ()
    """The old and new name of each remap."""
    environment: tuple[tuple[str, str], ...] = ()
    """The name and value of each environment variable that is set."""
    left_out: tuple[tuple[str, str], ...] = ()
    """The name of each parameter that could not be evaluated, and why; `*` for unknown names."""


@dataclass(frozen=True, slots=True)
class LaunchReading:
    """All that one launch file starts with the defaults of its arguments."""

    nodes: tuple[StartedNode, ...] = ()
    """The programs that it starts."""
    parameters: tuple[LaunchParameter, ...] = ()
    """The parameters of the server of ROS 1, which belong to no node; empty for ROS 2."""
    left_out: tuple[tuple[str, str], ...] = ()
    """The name of each such parameter that was not evaluated, and why."""
    sources: tuple[Path, ...] = ()
    """The files that were read."""
    problems: tuple[str, ...] = ()
    """What could not be read, in words."""
    robots: tuple[RobotSource, ...] = ()
    """The robot description files that it names."""
    missing: tuple[tuple[str, Path], ...] = ()
    """The places that load a file which is not there, with the file: roslaunch starts nothing."""


@dataclass(frozen=True, slots=True)
class LaunchSetup:
    """What a controller is given by the file that starts it."""

    file: str
    """The launch or parameter file, from the controller's root."""
    kind: Kind
    """`launch` for a launch file, `parameters` for a parameter file."""
    ros: Literal[1, 2]
    """The generation of ROS that the file is for."""
    name: str | None = None
    """The name that the node gets; `None` for its own."""
    namespace: str = ""
    """The namespace that the node gets; empty for the root."""
    arguments: tuple[str, ...] = ()
    """The arguments of the command line."""
    ros_arguments: tuple[str, ...] = ()
    """The arguments after `--ros-args`."""
    parameters: tuple[LaunchParameter, ...] = ()
    """The parameters that are set, of all nodes that the controller may ask."""
    remaps: tuple[tuple[str, str], ...] = ()
    """The old and new name of each remap."""
    environment: tuple[tuple[str, str], ...] = ()
    """The name and value of each environment variable that is set."""
    sources: tuple[str, ...] = ()
    """All files that were read, from the controller's root."""
    notes: tuple[str, ...] = ()
    """Sentences on what is given, for outputs."""
    own: tuple[LaunchParameter, ...] = ()
    """The parameters that are meant for the controller's own node."""
    missing: tuple[tuple[str, str], ...] = ()
    """The places that load a file which is not there, each with the file, from the root."""

    def argv(self, given: Sequence[str]) -> tuple[str, ...]:
        """Return the command line of the controller: what is `given` goes before the launch file's.

        Arguments of its own replace those of the launch file; remappings and parameters of the
        user win over those of the launch file.
        """
        return self._argv2(given) if self.ros == 2 else self._argv1(given)

    def _argv1(self, given: Sequence[str]) -> tuple[str, ...]:
        own = [name for name in given if ":=" not in name] or self.arguments
        rules = [f"{old}:={new}" for old, new in self.remaps]
        if self.name is not None:
            rules.append(f"__name:={self.name}")
        if self.namespace.strip("/"):
            rules.append(f"__ns:=/{self.namespace.strip('/')}")
        # Of two rules for one name the later one counts.
        return (*own, *rules, *(name for name in given if ":=" in name))

    def _argv2(self, given: Sequence[str]) -> tuple[str, ...]:
        own, theirs = split_arguments(given)
        launched, rules = split_arguments(self.arguments)
        rules += self.ros_arguments
        if self.name is not None:
            rules += ["-r", f"__node:={self.name}"]
        if self.namespace.strip("/"):
            rules += ["-r", f"__ns:=/{self.namespace.strip('/')}"]
        for old, new in self.remaps:
            rules += ["-r", f"{old}:={new}"]
        # Of two rules for one name the first one counts.
        rest = [*theirs, *rules]
        return (*(own or launched), *(["--ros-args", *rest] if rest else []))


def words_of_missing(place: str, file: str) -> str:
    """Return in words that a place of a launch file loads a file which is not there."""
    return (
        f"{place} loads {file}, {NOT_THERE}: its parameters are missing, and roslaunch starts "
        "nothing without it"
    )


NOTHING_LAUNCHED = LaunchSetup("", "launch", 1)
"""What a controller is given that no launch file starts."""


def split_arguments(argv: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments of the program itself, and those that are meant for ROS 2."""
    own: list[str] = []
    ros: list[str] = []
    within = False
    for argument in argv:
        if argument == "--ros-args":
            within = True
        elif within and argument == "--":
            within = False
        else:
            (ros if within else own).append(argument)
    return own, ros
