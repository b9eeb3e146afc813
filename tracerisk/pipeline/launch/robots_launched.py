"""Which robots the launch files around a controller describe, and what they give xacro for them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice, read_launch_files
from tracerisk.pipeline.launch.find import LaunchFile, launch_texts
from tracerisk.pipeline.launch.program import program_of, shown
from tracerisk.pipeline.launch.readme_arguments import ReadmeArguments
from tracerisk.pipeline.launch_files.records import RobotSource
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.workspace import named_packages, workspace_of
from tracerisk.twin.robots.names_in_source import LaunchedBy, LaunchedDescription
from tracerisk.twin.workspace.description_files import distance

_MOST_READ = {1: 40, 2: 4}  # launch files of ROS 2 cost a process each
_DESCRIBES = re.compile(r"\.xacro\b|\.urdf\b|MoveItConfigsBuilder|\bplanning_context\.launch\b")


def launched_robots(
    controller: Controller, settings: Settings, choice: LaunchChoice, strings: Iterable[str]
) -> tuple[LaunchedDescription, ...]:
    """Return the files of robots that launch files name, those of the controller's own first.

    Own are those of the launch file that starts it. Where that names none, the launch files of
    its package and of those that the controller's `strings` or its manifest name come next, then
    those of the rest of the workspace, as far as they give one file the same arguments. Where the
    controller's arguments name a parameter file, the launch files that read one beside it are
    its own.
    Nothing where the settings want no launch file.
    Raises LimitError where reading a launch file takes too long or too much memory.
    """
    if settings.launch is False:
        return ()
    own = [_described(robot_source, choice.file, "controller") for robot_source in choice.robots]
    given = choice.given
    if not given.files and any(description.path is not None for description in own):
        return tuple(own)
    root = controller.root.resolve()
    script = controller.path.resolve()
    workspace = workspace_of(controller, settings)
    ros = controller.ros_version
    program = program_of(script, root, workspace)
    texts = {
        path.resolve(): text
        for path, text in launch_texts(root, workspace, ros).items()
        if _DESCRIBES.search(text)
    }
    named = named_packages(root, workspace.packages, strings)
    folders = [root, *(workspace.packages[name].resolve() for name in sorted(named))]

    def whose(path: Path) -> LaunchedBy:
        if path.is_relative_to(folders[0]):
            return "package"
        return "named" if any(map(path.is_relative_to, folders)) else "workspace"

    paths = sorted(
        texts,
        key=lambda path: (
            not given.are_near(texts[path]),
            whose(path) == "workspace",
            distance(script, path),
            path,
        ),
    )[: _MOST_READ[ros]]
    readmes = ReadmeArguments(controller.project, workspace)
    files = [readmes.given(LaunchFile(path, ros, False)) for path in paths]
    readings = read_launch_files(files, workspace, settings.limits)
    is_given = any(reading.robots and given.beside(reading) for reading in readings)
    descriptions = [] if is_given else list(own)
    for file, reading in zip(files, readings, strict=True):
        by = whose(file.path)
        is_own = any(program.started_as(node) is not None for node in reading.nodes)
        if given.beside(reading) if is_given else is_own:
            by = "controller"
        name = shown([file.path], root)[0]
        said = f"{name} ({file.given})" if file.given else name
        descriptions += [_described(robot, said, by) for robot in reading.robots]
    return _agreed(descriptions)


def _described(source: RobotSource, file: str, by: LaunchedBy) -> LaunchedDescription:
    path = Path(source.path).resolve() if source.path else None
    if path is not None and not path.is_file():
        return LaunchedDescription(None, (), f"'{path.name}' is not here", file, by)
    return LaunchedDescription(path, source.arguments, source.problem, file, by)


def _agreed(found: Iterable[LaunchedDescription]) -> tuple[LaunchedDescription, ...]:
    """Return the descriptions, the nearest first; far ones that contradict each other are none."""
    order: tuple[LaunchedBy, ...] = ("controller", "package", "named", "workspace")
    kept: dict[tuple[Path | None, str], LaunchedDescription] = {}
    contradicted: set[Path | None] = set()
    for description in sorted(found, key=lambda one: order.index(one.by)):
        key = (description.path, description.problem)
        known = kept.setdefault(key, description)
        if known.by == "workspace" and known.arguments != description.arguments:
            contradicted.add(description.path)
    return tuple(
        description
        for description in kept.values()
        if description.path not in contradicted or description.path is None
    )
