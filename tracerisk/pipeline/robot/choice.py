"""Which robot a controller drives: the settings, its workspace, its strings, else a generic arm."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import require_simulator
from tracerisk.common.hardware.shipped import ADDED
from tracerisk.common.limits import Limits
from tracerisk.config import Settings
from tracerisk.errors import Location, RobotError
from tracerisk.pipeline.launch.choose import NOTHING_CHOSEN, LaunchChoice, choose_launch
from tracerisk.pipeline.launch.launch_hints import with_parameters
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.workspace.controller import Controller, string_literals
from tracerisk.pipeline.workspace.own_modules import with_own_modules
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import workspace_of
from tracerisk.twin.model_files.model_file import read_model_file
from tracerisk.twin.model_files.paths import ModelFolder
from tracerisk.twin.robots.added_gripper import (
    commands_gripper,
    named_robot,
    with_assumed_gripper,
    with_finger_joint,
    with_named_gripper,
)
from tracerisk.twin.robots.assumed_names import HAND
from tracerisk.twin.robots.generic import NAME as GENERIC
from tracerisk.twin.robots.generic import names_asked
from tracerisk.twin.robots.robot import is_model_file
from tracerisk.twin.robots.robot_names import words_in

if TYPE_CHECKING:
    from tracerisk.pipeline.robot.evidence import Evidence
    from tracerisk.twin.model_files.model_file import ModelFile
    from tracerisk.twin.robots.robot import Robot

_GROUP_NAMES = ("pymoveit2", "robots")
"""The library that has groups of its own for robots: AndrejOrsula/pymoveit2 pymoveit2/robots."""


@dataclass(frozen=True, slots=True)
class RobotChoice:
    """The robot that was taken, and why."""

    robot: Robot
    """The robot."""
    skipped: tuple[str, ...] = ()
    """The files of the workspace that were not taken."""
    files: tuple[Path, ...] = ()
    """Those that the robot was read from, if it is not a shipped one."""
    evidence: tuple[Evidence, ...] = ()
    """What speaks for it and for others, the strongest first; none where settings name it."""


def choose_launched_robot(
    controller: Controller,
    settings: Settings,
    launch: LaunchChoice,
    *,
    also_named: tuple[str, ...] = (),
) -> RobotChoice:
    """Return the robot that a controller and its parameters of a launch file mean.

    Raises RobotError as `choose_robot` does.
    """
    launched = with_parameters(controller, launch.setup, launch.given.parameters)
    return choose_robot(launched, settings, launch, also_named=also_named)


def choose_robot(
    controller: Controller,
    settings: Settings,
    launch: LaunchChoice = NOTHING_CHOSEN,
    *,
    also_named: tuple[str, ...] = (),
) -> RobotChoice:
    """Return the robot that a controller drives; its `chosen_by` says why it is this one.

    It is the one that the settings name, else the one that `searched_robot` finds. `launch` is
    what was chosen of launch files, `also_named` joints that the controller names in its run, and
    not in its source.
    Raises RobotError when the settings name none that is known.
    """
    origin = "as the settings say"
    if settings.robot is None:
        from tracerisk.pipeline.robot.search import searched_robot

        return searched_robot(controller, settings, launch, also_named)
    whole = with_own_modules(controller)
    if settings.robot == GENERIC:
        from tracerisk.pipeline.robot.search import stand_in

        return stand_in(controller, origin)
    if is_model_file(settings.robot):
        installed = workspace_of(controller, settings).installed
        read = read_model(controller.project, settings.robot, settings.limits, installed)
        return RobotChoice(replace(read.robot, chosen_by=origin), files=read.files)
    robot = named_robot(settings.robot)
    if any(parts[:2] == _GROUP_NAMES for _, parts in whole.project.imports(whole.source)):
        robot = with_groups_of(robot, string_literals(whole))
    return RobotChoice(equipped(replace(robot, chosen_by=origin), whole))


def with_groups_of(
    robot: Robot, strings: Iterable[str], states: Collection[str] = frozenset()
) -> Robot:
    """Return a shipped robot; it assumes names where a program names none of its own.

    These are groups, by the program's strings, and the named states that it asks for. Whoever
    wrote such a program has a configuration of MoveIt with other names. A single state that the
    robot lacks may as well be a mistake. What grippers have, `open`, says nothing about the arm.
    """
    fingers = {joint for gripper in robot.grippers for joint in gripper.joints}
    of_grippers: set[str] = set()
    own: set[str] = set()
    for group, known in robot.named_states.items():
        joints = robot.groups[group].joints if group in robot.groups else ()
        is_of_gripper = bool(joints) and fingers.issuperset(joints)
        (of_grippers if is_of_gripper else own).update(known)
    is_of_another = len({*states} - of_grippers) > 1 and own.isdisjoint(states)
    return replace(robot, assumes_names=is_of_another or words_in(strings).isdisjoint(robot.groups))


def with_groups_asked(robot: Robot, asked: Collection[str]) -> Robot:
    """Return a robot; it assumes names where a program asks for groups that can mean but one.

    These are a group of another name than the only one of the arm, or of the gripper. Who names
    the robot's own group of that kind too, means another arm, or has mistaken himself.
    """
    fingers = {joint for gripper in robot.grippers for joint in gripper.joints}
    arms, grippers = {}, {}
    for name, group in robot.groups.items():
        joints = frozenset(group.joints)
        if joints <= fingers:
            grippers[name] = joints
        else:
            # An arm has a group with its hand as well.
            arms[name] = joints - fingers
    hands = {name for name in asked if HAND.search(name) and "arm" not in name.lower()}
    pairs = ((hands, grippers), ({*asked} - hands, arms))
    unknown = [(named, own) for named, own in pairs if named - robot.groups.keys()]
    is_meant = all(
        len({*own.values()}) == 1 and own.keys().isdisjoint(named) for named, own in unknown
    )
    return replace(robot, assumes_names=True) if unknown and is_meant else robot


def equipped(robot: Robot, controller: Controller) -> Robot:
    """Return a robot, with a gripper if it has none and the controller commands one.

    It is the shipped one whose joint the controller names, else an assumed one.
    """
    if not robot.grippers and commands_gripper(controller.tree):
        joints = names_asked(controller.tree).joints
        return with_named_gripper(robot, joints) or with_assumed_gripper(robot, joints)
    if ADDED in robot.name:
        return with_finger_joint(robot, names_asked(controller.tree).joints)
    return robot


def read_model(
    project: Project, name: str, limits: Limits, installed: Mapping[str, Path] | None = None
) -> ModelFile:
    """Read the model file that the settings name; what it names stands in its own project.

    That is the controller's own root, or the nearest folder above the file that is marked as the
    root of one; the packages of the controller's workspace and of the file's, and those that are
    `installed`.
    Raises RobotError when it is malformed, or names a file elsewhere; LimitError when reading it
    takes too long or too much memory.
    """
    path = Path(name)
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError) as error:
        raise RobotError(f"names no file: {error}", Location(name)) from error
    is_own = resolved.is_relative_to(project.root.resolve())
    around = project if is_own else Project.of(path)
    packages = {**(installed or {}), **around.workspace().packages, **project.workspace().packages}
    folder = ModelFolder(resolved.parent, around.root.resolve(), packages)
    return read_model_file(path, folder, limits=limits)


def robot_files(controller: Controller, settings: Settings) -> tuple[Path, ...]:
    """Return the files that are read for a robot that the settings name by its file, that first.

    Raises RobotError as `choose_robot` does.
    """
    name = settings.robot
    if name is None or not Path(name).suffix:
        return ()
    if not is_model_file(name):
        return (Path(name),)
    installed = workspace_of(controller, settings).installed
    return read_model(controller.project, name, settings.limits, installed).files


def driven_robot(controller: Controller, settings: Settings) -> Robot:
    """Return the robot that the controller drives; `Robot.chosen_by` says why it is this one.

    It is that of the settings, else that of the controller's workspace, else the shipped one of
    which the controller's strings speak, with those of its launch file, else a generic arm.
    Raises RobotError when it is unknown, or several fit.
    """
    require_simulator("what reads a robot")
    settings = with_scenario(settings)
    launch = choose_launch(controller, settings) if settings.robot is None else NOTHING_CHOSEN
    return choose_launched_robot(controller, settings, launch).robot
