"""What a repository needs to begin with tracerisk: settings, hardware data, hook, CI."""

from __future__ import annotations

import ast
import contextlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.common.dependencies import missing_extras
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.hardware.starting_file import SCHEMA_NAME as HARDWARE_SCHEMA
from tracerisk.common.hardware.starting_file import starting_description, starting_yaml
from tracerisk.common.text.bounded import file_bytes, in_folder
from tracerisk.config import BlockForm, controller_root, is_root, repository_above
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.dotted_names import imports_in, last_name
from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.start.ci_files import Ci, StartFile, ci_files, template
from tracerisk.pipeline.start.schemas import SchemaName, schema_text
from tracerisk.pipeline.workspace.controller import from_root, load_controller
from tracerisk.pipeline.workspace.needs_in_source import asked_in_source
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import searched
from tracerisk.ros.vendors.driver_search import shipped_drivers

HOOK_FILE = ".pre-commit-config.yaml"
"""The file at the top of the repository from which pre-commit installs hooks of git."""
SETTINGS_SCHEMA = "pyproject.schema.json"
"""The file at the top of the repository that new settings refer to."""

_REFERENCE = b"#:schema "
"""How a TOML file begins that says by which schema it is written."""
_SCENARIO = ".scenario.yaml"
"""How the name of a scenario ends that `tracerisk scenario --write` writes beside a controller."""
_SUBJECTS = {"hardware": "failure data", "pyproject": "settings"}

_CLIENTS = frozenset(
    {
        *("rospy", "rclpy", "moveit_commander", "moveit", "actionlib", "pymoveit2"),
        *("intera_interface", "baxter_interface", "interbotix_xs_modules", "kortex_driver"),
    }
)
_BEGINS = frozenset({"init_node", "init", "roscpp_initialize", "MoveItPy", "spin", "run"})
_LEFT_OUT = frozenset(
    {"build", "install", "log", "dist", "site-packages", "node_modules", "test", "tests"}
)
_MOST_BYTES = 1_000_000
_MOST_READ = 30
"""How many controllers are asked for their robot, and for what they need."""
_OF_A_CELL = frozenset({"topic", "service", "action", "frame", "call", "goal", "input"})
_OF_ROBOTS = frozenset({"control_msgs", "moveit_msgs", "trajectory_msgs", "franka_gripper"})
"""Packages whose messages go to an arm, which the twin answers."""


@dataclass(frozen=True, slots=True)
class ProjectStart:
    """What was found in a repository, and what it lacks."""

    root: Path
    """The top folder of the repository."""
    controllers: tuple[str, ...]
    """The files of controllers, from the root."""
    robots: Mapping[str, tuple[str, ...]]
    """The controllers that drive each robot, by the robot's name."""
    robot_why: str
    """Why no robot is known for a controller, in words; empty where all are."""
    assumed_grippers: tuple[str, ...]
    """For each robot whose gripper nobody names, how to name it, in words."""
    settings_lack: tuple[str, ...]
    """What existing settings should say of the robot and its hardware, as sentences."""
    asked: Mapping[str, tuple[str, ...]]
    """What each controller's source asks its cell for, in words; a scenario may have to provide
    it."""
    files: tuple[StartFile, ...]
    """The files to write."""


def project_start(
    root: Path,
    *,
    robot: str | None = None,
    ci: Ci = "none",
    blocks: BlockForm | None = None,
) -> ProjectStart:
    """Return what a repository lacks to begin with tracerisk; nothing is written.

    Files that are there stay as they are, but for `pyproject.toml`, which gets the table
    `[tool.tracerisk]` at its end where it has none. Settings are those of a controller's root:
    in a ROS workspace each package has its own `pyproject.toml`.
    Raises RobotError for an unknown robot, SettingsError for a malformed `pyproject.toml`.
    """
    controllers = tuple(_controllers(root))
    robots, why, assumed = _robots(root, controllers, robot)
    files: list[StartFile] = []
    described: dict[str, str] = {}
    schemas: dict[str, SchemaName] = {}
    for name in robots:
        path = "hardware.yaml" if len(robots) == 1 else f"hardware_{name}.yaml"
        started = None if (root / path).exists() else _hardware(name)
        if started is not None:
            text, added = started
            words = "failure data, to be replaced by your own value by value"
            if added:
                words += (
                    f"; beside what is counted without the file it has {' and '.join(added)} with "
                    "assumed figures, so risk figures rise with the next run"
                )
            files.append(StartFile(path, text.encode(), words))
            schemas[HARDWARE_SCHEMA] = "hardware"
        if started is not None or (root / path).exists():
            described[name] = path
    settings, lacking = _settings(root, controllers, robots, described, robot, blocks)
    files += settings
    if any(file.content.startswith(_REFERENCE) for file in settings):
        schemas[SETTINGS_SCHEMA] = "pyproject"
    for path, kind in schemas.items():
        if not (root / path).exists():
            words = f"by which editors complete and check {_SUBJECTS[kind]}"
            files.append(StartFile(path, schema_text(kind).encode(), words))
    # pre-commit and the servers of git read only what is at the top of a repository.
    top = repository_above(root / HOOK_FILE) or root
    if not (top / HOOK_FILE).exists():
        files.append(
            StartFile(
                from_root(root.resolve(), top.resolve() / HOOK_FILE),
                template("pre-commit.yaml"),
                "the hook: refuses commits with stale risk blocks",
            )
        )
    files += (
        replace(file, path=from_root(root.resolve(), top.resolve() / file.path))
        for file in ci_files(top, ci)
    )
    asked = _asked(root, controllers)
    return ProjectStart(
        root, controllers, robots, why, assumed, tuple(lacking), asked, tuple(files)
    )


def _controllers(root: Path) -> Iterator[str]:
    """Yield the Python programs that take the part of a ROS node, by their paths from the root."""
    for folder, names in searched(root, _LEFT_OUT, environments=False):
        for name in names:
            path = Path(folder, name)
            if name.endswith(".py") and not name.endswith(".launch.py") and _is_controller(path):
                yield path.relative_to(root).as_posix()


def _is_controller(path: Path) -> bool:
    try:
        if path.stat().st_size > _MOST_BYTES:
            return False
        tree = parsed(file_bytes(path))
    except OSError:
        return False
    if tree is None:
        return False
    imported = {parts[0] for level, parts in imports_in(tree) if parts and not level}
    called = {last_name(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    return bool(imported & _CLIENTS) and bool(called & _BEGINS)


def _robots(
    root: Path, controllers: tuple[str, ...], given: str | None
) -> tuple[dict[str, tuple[str, ...]], str, tuple[str, ...]]:
    """Return the controllers of each robot, why one is unknown, and which grippers are assumed."""
    if "sim" in missing_extras():
        named = _robots_of_settings(root, controllers) if given is None else {given: controllers}
        known = sum(map(len, named.values()))
        why = "" if known == len(controllers) > 0 else "the simulator is not installed"
        return named, why, ()
    from tracerisk.pipeline.robot import choice
    from tracerisk.twin.robots import added_gripper
    from tracerisk.twin.robots.generic import NAME as GENERIC

    robot = None if given is None else added_gripper.named_robot(given)
    robots: dict[str, list[str]] = {}
    assumed: dict[str, str] = {}
    why = "" if controllers else "no controller was found"
    for text in controllers[:_MOST_READ]:
        try:
            controller = load_controller(root / text)
            driven = (
                choice.driven_robot(controller, controller.settings)
                if robot is None
                else choice.equipped(robot, controller)
            )
        except TraceRiskError as error:
            why = why or f"{text}: {error.message}"
            continue
        if driven.name == GENERIC:
            why = why or f"{text} names none that is known"
            continue
        robots.setdefault(driven.name, []).append(text)
        if added_gripper.has_assumed_gripper(driven):
            assumed[driven.name] = added_gripper.words_of_assumed_gripper(driven)
    if robot is not None:
        return {robot.name: controllers}, "", tuple(assumed.values())
    return {name: tuple(files) for name, files in robots.items()}, why, tuple(assumed.values())


def _robots_of_settings(root: Path, controllers: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Return the controllers of each robot that their settings name."""
    robots: dict[str, tuple[str, ...]] = {}
    for text in controllers:
        with contextlib.suppress(TraceRiskError):
            robot = load_controller(root / text).settings.robot
            if robot is not None:
                robots[robot] = (*robots.get(robot, ()), text)
    return robots


def _asked(root: Path, controllers: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Return what each source asks for that is no part of a robot or its drivers."""
    if "sim" in missing_extras():
        return {}
    of_robots = _OF_ROBOTS.union(*(shipped_driver.packages for shipped_driver in shipped_drivers()))
    texts = {}
    for name in controllers[:_MOST_READ]:
        try:
            asked = asked_in_source(load_controller(root / name))
        except TraceRiskError:
            continue
        told = tuple(
            missed.need.words
            for missed in asked
            if missed.need.kind in _OF_A_CELL
            and missed.need.type_name.partition("/")[0] not in of_robots
            and missed.need.type_name != "sensor_msgs/JointState"
        )
        if told:
            texts[name] = told
    return texts


def _hardware(robot: str) -> tuple[str, list[str]] | None:
    """Return a description to start from, and the components that the shipped one lacks."""
    if "sim" in missing_extras():
        return None
    from tracerisk.twin.robots.added_gripper import named_robot

    try:
        result = named_robot(robot)
    except TraceRiskError:
        # A robot of the workspace itself has no name under which it could be read again.
        return None
    joints = {name: group.joints for name, group in result.groups.items()}
    shipped = hardware_of(robot)
    description = starting_description(robot, result.elements, joints, shipped)
    known = {component.name for component in shipped.components}
    added = [
        component.name
        for component in description.components
        if component.twin is not None and component.twin.sensors and component.name not in known
    ]
    return starting_yaml(description, result.title), added


def _settings(
    root: Path,
    controllers: Sequence[str],
    robots: Mapping[str, Sequence[str]],
    described: Mapping[str, str],
    given: str | None,
    blocks: BlockForm | None,
) -> tuple[list[StartFile], list[str]]:
    """Return the settings of each root of controllers: a package of a workspace has its own.

    And what those that are there lack of the robot that is `given`, of the hardware of each
    controller and of the form of blocks.
    """
    root = root.resolve()
    names: dict[Path, dict[str, str]] = {} if controllers else {root: {}}
    robot_of = {file: name for name, files in robots.items() for file in files}
    for controller in controllers:
        path = root / controller
        folder = controller_root(path)
        if not is_root(folder):
            folder = root  # the settings written there will make it the root
        name = from_root(folder, path)
        names.setdefault(folder, {})[name] = robot_of.get(controller, "")
    files: list[StartFile] = []
    lacking: list[str] = []
    for folder, item in names.items():
        paths = {robot: from_root(folder, root / file) for robot, file in described.items()}
        path = folder / "pyproject.toml"
        shown = from_root(root, path)
        project = Project(folder)
        settings = project.settings()
        before = file_bytes(path) if path.exists() else b""
        named = given
        if given is not None and Path(given).is_file():
            named = from_root(folder, Path(given))
        own = _lines_of(item, paths, named)
        form = [] if blocks in (None, settings.blocks) else [f"blocks = {json.dumps(blocks)}"]
        if b"[tool.tracerisk" not in before:
            files.append(_settings_of(shown, before, [*own, *form], item, paths, folder))
            continue
        unread = {
            file: robot
            for file, robot in item.items()
            if robot in paths and project.settings(file).hardware is None
        }
        if given is None or settings.robot is not None:
            of_all = unread.keys() == item.keys() and settings.hardware is None
            own = _lines_of(unread, paths, None) if of_all else []
        lacks = [*own, *form]
        if lacks:
            lacking.append(f"{shown} is kept as it is; add to [tool.tracerisk]: {', '.join(lacks)}")
        if not any(line.startswith("hardware = ") for line in own):
            lacking += [
                f"{shown} is kept as it is; add to {table}: {line}"
                for table, line in _own_tables(unread, paths)
            ]
        if unread:
            unnamed = ", ".join(sorted({paths[robot] for robot in unread.values()}))
            lacking[-1] += f"; without it, no run reads {unnamed}"
    return files, lacking


def _own_tables(
    robot_of: Mapping[str, str], described: Mapping[str, str]
) -> Iterator[tuple[str, str]]:
    """Yield the table of each controller whose robot is described, and the setting in it."""
    for name, robot in robot_of.items():
        if robot in described:
            yield _own_table(name), f"hardware = {json.dumps(described[robot])}"


def _own_table(file: str) -> str:
    """Return the table of the settings of one controller."""
    return f"[tool.tracerisk.controllers.{json.dumps(file)}]"


def _lines_of(
    robot_of: Mapping[str, str], described: Mapping[str, str], given: str | None
) -> list[str]:
    """Return the settings of all controllers of a folder: a robot that was given, its data."""
    own = [] if given is None else [f"robot = {json.dumps(given)}"]
    used = set(robot_of.values()) or set(described)
    if len(used) == 1:
        own += [f"hardware = {json.dumps(described[key])}" for key in used & set(described)]
    return own


def _settings_of(
    shown: str,
    before: bytes,
    own: Sequence[str],
    robot_of: Mapping[str, str],
    described: Mapping[str, str],
    folder: Path,
) -> StartFile:
    """Return the settings of a folder, whose controllers have these robots."""
    scenarios = {path.name for path in in_folder(folder, _SCENARIO)}
    by_controller = {
        file: scenario
        for file in robot_of
        if (scenario := f"{Path(file).stem}{_SCENARIO}") in scenarios
    }
    tables: dict[str, list[str]] = {}
    if len(scenarios) == 1 and (len(robot_of) == 1 or not by_controller):
        own = [*own, f"scenario = {json.dumps(*scenarios)}"]
    else:
        for file, scenario in by_controller.items():
            tables[_own_table(file)] = [f"scenario = {json.dumps(scenario)}"]
    lines = [
        "[tool.tracerisk]",
        *own,
        "# The mission is not trusted where less of the code that can move the arm has run.",
        "# min_coverage = 0.8",
        "# No commit may make a mission fail more often than this.",
        "# max_failure_probability = 1e-5",
    ]
    if len(set(robot_of.values())) > 1:
        for table, setting in _own_tables(robot_of, described):
            tables.setdefault(table, []).append(setting)
    for table, settings in tables.items():
        lines += ["", table, *settings]
    newline = "\r\n" if b"\r\n" in before else "\n"
    gap = "" if not before else newline if before.endswith(b"\n") else 2 * newline
    text = gap + newline.join(lines) + newline
    if not before:
        # A schema that is named there is the only one that an editor takes for a file: one that
        # has other tables already is left to the editor's own.
        schema = os.path.relpath(SETTINGS_SCHEMA, Path(shown).parent)
        text = f"{_REFERENCE.decode()}{Path(schema).as_posix()}\n{text}"
    inside = Path(shown).parent.as_posix()
    words = "settings of all controllers" + ("" if inside == "." else f" of {inside}")
    return StartFile(shown, before + text.encode(), words, is_new=not before)
