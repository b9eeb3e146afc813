"""Failures for want of a part that another robot of the workspace has: the controller is right."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from tracerisk.common.verdict import Reason, Verdict
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.workspace.description_files import DescriptionFile, description_files

_QUOTED = re.compile(r"'([A-Za-z][\w/.-]*)'")
_LACKS = re.compile(
    r"has no|no such|unknown|not (?:found|known|part of)|does not exist|is not in|is no |allowed: "
)
_CODE = "robot-assumed"


def not_blamed(verdict: Verdict, robot: Robot, controller: Controller) -> Verdict:
    """Return the verdict with what only the choice of the robot explains as matters of that.

    These are failures over the name of a joint, group or link that the robot lacks, and that
    another description of the workspace has. Files are searched only where there is such a one.
    """
    lacked = {
        name: reason
        for reason in verdict.reasons
        if reason.verdict == "faulted" and _LACKS.search(reason.words)
        for name in _QUOTED.findall(reason.words)
        if name not in _parts(robot)
    }
    if not lacked:
        return verdict
    files = [*_others(controller, robot)]
    elsewhere = {name: file.shown for name in lacked for file in files if name in file.words}
    reasons = tuple(_as_choice(reason, robot, elsewhere) for reason in verdict.reasons)
    return replace(verdict, reasons=reasons)


def _as_choice(reason: Reason, robot: Robot, elsewhere: dict[str, str]) -> Reason:
    if reason.verdict != "faulted":
        return reason
    names = [name for name in _QUOTED.findall(reason.words) if name in elsewhere]
    if not names:
        return reason
    file = elsewhere[names[0]]
    words = (
        f"{reason.words}; {file} has '{names[0]}', so the controller may drive that robot and not "
        f"{robot.name}: name it with --robot {file}"
    )
    return replace(reason, code=_CODE, verdict="partial", words=words)


def _parts(robot: Robot) -> frozenset[str]:
    joints = (hung.name for hung in robot.attachments)
    return frozenset({robot.name, *robot.link_names, *robot.groups, *joints})


def _others(controller: Controller, robot: Robot) -> Iterator[DescriptionFile]:
    """Yield the descriptions of the workspace but for those that the robot is from."""
    packages = controller.workspace.packages
    own = set(re.split(r", ", robot.source))
    for file in description_files((controller.root, *packages.values())):
        if file.is_robot and file.shown not in own:
            yield file
