"""The robots that files of a workspace describe, and which of them a controller may mean."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tracerisk.twin.robots.names_in_source import LaunchedBy
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.urdf.srdf import Srdf


@dataclass(frozen=True, slots=True)
class DescribedRobot:
    """A robot that files of the workspace describe."""

    robot: Robot
    """The robot; one of `like` where the workspace has its SRDF alone."""
    reason: str
    """The files, and what names them, for messages."""
    key: str
    """What the description is called: its first file."""
    files: tuple[Path, ...]
    """The files that it was read from."""
    launched_by: LaunchedBy | None
    """Whose launch file names it, `None` for none."""
    launch_file: str
    """That launch file."""
    is_near: bool
    """Whether it is in the controller's package, or in one that it names."""
    is_called: bool
    """Whether the controller names the robot by its name."""
    is_only: bool
    """Whether the workspace has no other, but for those of tests."""
    srdf: Srdf | None = None
    """Its groups and states, where no URDF has their joints."""
    like: tuple[str, ...] = ()
    """The shipped robots that have the joints of the SRDF."""
    prefix: str = ""
    """What the SRDF has before the names of these joints."""


@dataclass(frozen=True, slots=True)
class WorkspaceRobots:
    """What was found in a workspace."""

    described: tuple[DescribedRobot, ...]
    """The robots that may be meant: the best with an SRDF, and the best of the others."""
    skipped: tuple[str, ...] = ()
    """Files that were looked at and not taken, each with its reason."""
    unreadable: tuple[str, ...] = ()
    """Those of them that the controller means and that cannot be read."""
