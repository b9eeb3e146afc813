"""Which robot a controller drives: the settings, its workspace, its strings, else a generic arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.config import Settings, controller_root
from tracerisk.errors import Location, RobotError
from tracerisk.limited_process import Limits
from tracerisk.pipeline.controller import Controller, string_literals
from tracerisk.pipeline.launch.records import LaunchSetup
from tracerisk.pipeline.launch.spoken import with_parameters
from tracerisk.pipeline.own_modules import with_own_modules
from tracerisk.pipeline.workspace import find_workspace, named_packages
from tracerisk.twin.robot import is_model_file

if TYPE_CHECKING:
    from tracerisk.twin.model_file import ModelFile
    from tracerisk.twin.robot import Robot


@dataclass(frozen=True, slots=True)
class RobotChoice:
    """The robot that was taken, and files of the workspace that were not, each with its reason.

    `files` are those that the robot was read from, if it is not a shipped one.
    """

    robot: Robot
    skipped: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()


def choose_launched_robot(
    controller: Controller,
    settings: Settings,
    launch: LaunchSetup | None,
    *,
    also_named: tuple[str, ...] = (),
) -> RobotChoice:
    """Return the robot of which a controller's source speaks, or its parameters of a launch file.

    Raises RobotError as `choose_robot` does; a name that only the launch file has raises none.
    """
    from tracerisk.twin.workspace import UnreadableRobotError

    try:
        return choose_robot(with_parameters(controller, launch), settings, also_named=also_named)
    except RobotError as error:
        if isinstance(error, UnreadableRobotError) or launch is None or not launch.own:
            raise
        return choose_robot(controller, settings, also_named=also_named)


def choose_robot(
    controller: Controller, settings: Settings, *, also_named: tuple[str, ...] = ()
) -> RobotChoice:
    """Return the robot that a controller drives; its `chosen_by` says why it is this one.

    `also_named` are joints that it names in its run, and not in its source.
    Raises RobotError when the settings name none that is known, several fit equally well, or that
    of the workspace cannot be read.
    """
    from tracerisk.pipeline.robot_hints import robot_hints
    from tracerisk.twin.detect import NoRobotNamedError, SeveralRobotsError, detect_robot
    from tracerisk.twin.generic import generic_arm, names_asked
    from tracerisk.twin.robot import load_robot
    from tracerisk.twin.workspace import NamedParts, UnreadableRobotError, find_workspace_robot

    whole = with_own_modules(controller)
    if settings.robot == "generic":
        arm = generic_arm(names_asked(whole.source))
        return RobotChoice(replace(arm, chosen_by="as the settings say"))
    if settings.robot is not None and is_model_file(settings.robot):
        read = read_model(controller.root, settings.robot, settings.limits)
        robot = replace(read.robot, chosen_by="as the settings say")
        return RobotChoice(robot, files=read.files)
    if settings.robot is not None:
        robot = replace(load_robot(settings.robot), chosen_by="as the settings say")
        return RobotChoice(_equipped(robot, whole))
    strings = (*string_literals(controller), *string_literals(whole), *also_named)
    packages = _own_packages(controller.root)
    roots = (controller.root, *packages.values())
    named = NamedParts(*named_packages(controller.root, packages, strings))
    found = find_workspace_robot(roots, packages, strings, controller.path, named, settings.limits)
    if found.robot is not None and found.is_named:
        return RobotChoice(replace(found.robot, chosen_by=found.reason), found.skipped, found.files)
    asked = names_asked(whole.source)
    asked = replace(asked, joints=tuple(dict.fromkeys((*also_named, *asked.joints))))
    try:
        robot = detect_robot(strings, robot_hints(controller), asked.joints)
    except (NoRobotNamedError, SeveralRobotsError) as error:
        if found.robot is not None:
            return RobotChoice(
                replace(found.robot, chosen_by=found.reason), found.skipped, found.files
            )
        if isinstance(error, SeveralRobotsError):
            raise
        if found.unreadable:
            # Another arm in its place would give figures of a robot that is not there.
            raise UnreadableRobotError(
                f"the robot of the workspace cannot be read: {'; '.join(found.unreadable)}; mend "
                "the file, or say with --robot which robot it is: a file, a shipped one, or "
                "generic for a stand-in"
            ) from error
        robot = replace(
            generic_arm(asked),
            chosen_by="a stand-in for the robot, which is not known: name it with --robot",
        )
    return RobotChoice(_equipped(robot, whole), found.skipped)


def _equipped(robot: Robot, controller: Controller) -> Robot:
    """Return a shipped robot, with an assumed gripper if it has none and the controller does."""
    from tracerisk.twin.assumed_gripper import commands_gripper, with_assumed_gripper
    from tracerisk.twin.generic import names_asked

    if robot.grippers or not commands_gripper(controller.source):
        return robot
    return with_assumed_gripper(robot, names_asked(controller.source).joints)


def read_model(root: Path, name: str, limits: Limits) -> ModelFile:
    """Read the model file that the settings name; what it names stands in its own project.

    That is the controller's own root, or the nearest folder above the file that is marked as the
    root of one; and the packages of the controller's workspace and of the file's.
    Raises RobotError when it is malformed, or names a file elsewhere; LimitError when reading it
    takes too long or too much memory.
    """
    from tracerisk.twin.model_file import read_model_file
    from tracerisk.twin.model_file_paths import ModelFolder

    path = Path(name)
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError) as error:
        raise RobotError(f"names no file: {error}", Location(name)) from error
    top = root.resolve() if resolved.is_relative_to(root.resolve()) else controller_root(path)
    packages = {**_own_packages(top), **_own_packages(root)}
    return read_model_file(path, ModelFolder(resolved.parent, top, packages), limits=limits)


def robot_files(controller: Controller, settings: Settings) -> tuple[Path, ...]:
    """Return the files that are read for a robot that the settings name by its file, that first.

    Raises RobotError as `choose_robot` does.
    """
    name = settings.robot
    if name is None or not Path(name).suffix:
        return ()
    if not is_model_file(name):
        return (Path(name),)
    return read_model(controller.root, name, settings.limits).files


def _own_packages(root: Path) -> Mapping[str, Path]:
    """Return the packages of the controller's own project."""
    return find_workspace(root).packages
