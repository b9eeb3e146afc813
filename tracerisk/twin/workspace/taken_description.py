"""A description that is taken for the robot, and how strongly."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.urdf.srdf import Srdf
from tracerisk.twin.workspace.description_files import DescriptionFile


@dataclass(frozen=True, slots=True)
class Taken:
    """A robot that was read."""

    robot: Robot
    """The robot."""
    reason: str
    """The files, and what names them, for messages."""
    files: tuple[DescriptionFile, ...]
    """An SRDF, if there is one, and a URDF."""
    left_out: str = ""
    """What is before its joints, and not where the controller names them."""
    is_only: bool = False
    """Whether there is no other of its kind."""
    srdf: Srdf | None = None
    """The SRDF, where there is no URDF."""
    like: tuple[str, ...] = ()
    """The shipped robots with its joints."""
    prefix: str = ""
    """What it has before the names of these joints."""


def doubted(robot: Robot, doubt: str) -> Robot:
    """Return a robot with one more doubt about it."""
    return replace(robot, doubt="; ".join(name for name in (robot.doubt, doubt) if name))


def among_rivals(robot: Robot, rivals: Iterable[str]) -> Robot:
    """Return a robot, doubted where files of the workspace describe others as likely."""
    if named := ", ".join(rivals):
        return doubted(robot, f"{named} in the workspace would fit as well; name it with --robot")
    return robot
