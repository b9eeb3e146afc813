"""Which robot a controller drives: the settings, its workspace, its strings, else a generic arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.config import Settings
from tracerisk.pipeline.controller import Controller, string_literals
from tracerisk.pipeline.workspace import find_workspace

if TYPE_CHECKING:
    from tracerisk.twin.robot import Robot


@dataclass(frozen=True, slots=True)
class RobotChoice:
    """The robot that was taken, and files of the workspace that were not, each with its reason."""

    robot: Robot
    skipped: tuple[str, ...] = ()


def choose_robot(controller: Controller, settings: Settings) -> RobotChoice:
    """Return the robot that a controller drives; its `chosen_by` says why it is this one.

    Raises RobotError when the settings name none that is known, or several fit equally well.
    """
    from tracerisk.twin.detect import NoRobotNamedError, detect_robot
    from tracerisk.twin.generic import generic_arm, names_asked
    from tracerisk.twin.robot import load_robot
    from tracerisk.twin.workspace import find_workspace_robot

    if settings.robot == "generic":
        arm = generic_arm(names_asked(controller.source))
        return RobotChoice(replace(arm, chosen_by="as the settings say"))
    if settings.robot is not None:
        return RobotChoice(replace(load_robot(settings.robot), chosen_by="as the settings say"))
    strings = string_literals(controller)
    packages = _own_packages(controller.root)
    roots = (controller.root, *packages.values())
    found = find_workspace_robot(roots, packages, strings, controller.path)
    if found.robot is not None and found.is_named:
        return RobotChoice(replace(found.robot, chosen_by=found.reason), found.skipped)
    try:
        robot = replace(
            detect_robot(strings, str(controller.path)),
            chosen_by="told by the names in the controller's strings",
        )
    except NoRobotNamedError:
        if found.robot is not None:
            return RobotChoice(replace(found.robot, chosen_by=found.reason), found.skipped)
        robot = replace(
            generic_arm(names_asked(controller.source)),
            chosen_by="a stand-in for the robot, which is not known: name it with --robot",
        )
    return RobotChoice(robot, found.skipped)


def _own_packages(root: Path) -> Mapping[str, Path]:
    """Return the packages of the controller's repository; without one, those beside its own."""
    top = root.resolve()
    around = next((each for each in (top, *top.parents) if (each / ".git").exists()), top.parent)
    return {
        name: folder
        for name, folder in find_workspace(root).packages.items()
        if folder.is_relative_to(around)
    }
