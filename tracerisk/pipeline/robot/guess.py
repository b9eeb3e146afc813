"""With which robot a controller may be tried whose own is unknown."""

from __future__ import annotations

from dataclasses import dataclass

from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.robot.search import stand_in
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.twin.robots.detect import SeveralRobotsError
from tracerisk.twin.robots.generic import NAME as GENERIC
from tracerisk.twin.workspace.robot_of_workspace import UnreadableRobotError

_MOST_NAMED = 5


@dataclass(frozen=True, slots=True)
class RobotGuess:
    """A robot for a scenario, and why it is this one."""

    name: str
    remark: str


def guessed_robot(error: TraceRiskError | None) -> RobotGuess | None:
    """Return a robot to assume where an error says that none is known, else `None`."""
    if isinstance(error, SeveralRobotsError) and error.names:
        others = ", ".join(error.names[1:_MOST_NAMED])
        more = " and others" if len(error.names) > _MOST_NAMED else ""
        return RobotGuess(error.names[0], f"one of several that fit, as do {others}{more}")
    if isinstance(error, UnreadableRobotError):
        remark = "a stand-in, for that of the workspace cannot be read; better give its file"
        return RobotGuess(GENERIC, remark)
    return None


def may_be_assumed(controller: Controller, error: TraceRiskError) -> bool:
    """Return whether a run may go on with the robot that is guessed.

    Of one that cannot be read the workspace must have the SRDF, so that the stand-in has its
    groups, joints and links; another arm would give figures of a robot that is not there.
    """
    if not isinstance(error, UnreadableRobotError):
        return guessed_robot(error) is not None
    return bool(stand_in(controller, "a stand-in").files)
