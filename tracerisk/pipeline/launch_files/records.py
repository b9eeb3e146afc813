"""What is read of launch files: the nodes that they start, and what they give to each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tracerisk.pipeline.launch_files.robot_sources import RobotSource
from tracerisk.ros.graph.parameter_files import EVERY_NODE, Parameter

__all__ = [
    "EVERY_NODE",
    "LaunchParameter",
    "LaunchReading",
    "LaunchSetup",
    "RobotSource",
    "StartedNode",
]

LaunchParameter = Parameter
"""A parameter: of ROS 2 that of a node (`/**`: of all); of ROS 1 its global name, node None."""

Kind = Literal["launch", "parameters"]
"""What a setup was read from: a launch file, or a parameter file that names the node."""


@dataclass(frozen=True, slots=True)
class StartedNode:
    """A program that a launch file starts.

    `package` and `executable` are empty where it is started by a `command`.
    `left_out` are the parameters that could not be evaluated, each with its reason.
    """

    package: str
    executable: str
    name: str | None = None
    namespace: str = ""
    command: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()
    ros_arguments: tuple[str, ...] = ()
    parameters: tuple[LaunchParameter, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    environment: tuple[tuple[str, str], ...] = ()
    left_out: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class LaunchReading:
    """All that one launch file starts with the defaults of its arguments.

    `parameters` are those of ROS 1, for its parameter server knows no owners; `left_out` those of
    them that were not evaluated. `sources` are the files that were read, `problems` what could
    not be. `robots` are the files of robots that it names.
    """

    nodes: tuple[StartedNode, ...] = ()
    parameters: tuple[LaunchParameter, ...] = ()
    left_out: tuple[tuple[str, str], ...] = ()
    sources: tuple[Path, ...] = ()
    problems: tuple[str, ...] = ()
    robots: tuple[RobotSource, ...] = ()


@dataclass(frozen=True, slots=True)
class LaunchSetup:
    """What a controller is given by the file that starts it.

    `file` and `sources` are paths from the controller's root; `notes` are the lines that say so.
    `own` are those of the parameters that are meant for the controller's own node.
    """

    file: str
    kind: Kind
    ros: Literal[1, 2]
    name: str | None = None
    namespace: str = ""
    arguments: tuple[str, ...] = ()
    ros_arguments: tuple[str, ...] = ()
    parameters: tuple[LaunchParameter, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    environment: tuple[tuple[str, str], ...] = ()
    sources: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    own: tuple[LaunchParameter, ...] = ()

    def argv(self, given: Sequence[str]) -> tuple[str, ...]:
        """Return the command line of the controller: what is `given` goes before the launch file's.

        Arguments of its own replace those of the launch file; remappings and parameters of the
        user win over those of the launch file.
        """
        return self._argv2(given) if self.ros == 2 else self._argv1(given)

    def _argv1(self, given: Sequence[str]) -> tuple[str, ...]:
        own = [each for each in given if ":=" not in each] or self.arguments
        rules = [f"{old}:={new}" for old, new in self.remaps]
        if self.name is not None:
            rules.append(f"__name:={self.name}")
        if self.namespace.strip("/"):
            rules.append(f"__ns:=/{self.namespace.strip('/')}")
        # Of two rules for one name the later one counts.
        return (*own, *rules, *(each for each in given if ":=" in each))

    def _argv2(self, given: Sequence[str]) -> tuple[str, ...]:
        own, theirs = _split(given)
        launched, rules = _split(self.arguments)
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


NOTHING_LAUNCHED = LaunchSetup("", "launch", 1)
"""What a controller is given that no launch file starts."""


def _split(argv: Sequence[str]) -> tuple[list[str], list[str]]:
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
