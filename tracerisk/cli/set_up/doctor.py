"""`tracerisk doctor`: whether everything that tracerisk needs works here."""

from __future__ import annotations

import argparse
import os
import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import print_json, show, terminal_width
from tracerisk.common.dependencies import install_command, missing_extras, needed, version_of
from tracerisk.common.sandbox.kernel.control_groups import group_folder
from tracerisk.common.sandbox.kernel.features import offers_own_network, support
from tracerisk.common.version import __version__
from tracerisk.config import Settings
from tracerisk.errors import DependencyError, ExitCode, LimitError, TraceRiskError
from tracerisk.pipeline.workspace.prefixes import installed_packages
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.ros_distro import choose_distro
from tracerisk.pipeline.workspace.workspace import prefixes_of
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot, robot_names

if TYPE_CHECKING:
    from tracerisk.pipeline.workspace.controller import Controller
    from tracerisk.pipeline.workspace.prefixes import Prefix
    from tracerisk.twin.robots.robot import Robot


_MANY = 4


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "controller", metavar="FILE", nargs="?", help="controller whose robot and settings to show"
    )
    parser.add_argument("--robot", metavar="NAME|FILE", help="robot (default: as a run infers it)")
    shared.add_sandbox(parser)
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    shown: dict[str, str] = {
        "tracerisk": __version__,
        "python": f"{platform.python_version()} ({sys.platform})",
    }
    faults: dict[str, str] = {}
    _packages(shown, faults)
    missing = missing_extras()
    for extra in missing:
        shown[f"extra {extra}"] = f"not installed: {install_command(extra)}"
    if "sim" not in missing:
        _look(shown, faults, "engine", _engine)
        _look(shown, faults, "physics", _physics)
    _look(shown, faults, "robots", _robots)
    if sys.platform == "linux":
        _look(shown, faults, "sandbox", _sandbox)
    else:
        shown["controllers"] = "run on Linux alone; `tracerisk run FILE` says how to have one here"
    settings: dict[str, dict[str, Any]] = {}
    if options.controller is None:
        shown["installed ROS"] = _of_environment()
    else:
        given = {"robot": options.robot, "sandbox": options.sandbox}
        controller = api.load_controller(options.controller)
        in_use = api.load_settings(controller, given)
        shown.update(_of_controller(controller, in_use))
        settings = _settings(controller, in_use, given)
    code = ExitCode.INTERNAL_FAULT if faults else ExitCode.FINE
    if options.json:
        print_json("doctor", exit_code=int(code), found=shown, settings=settings, faults=faults)
        return int(code)
    for name, text in shown.items():
        show(*_wrapped(f"{name}: {text}"))
    if settings:
        show("settings:")
    # A terminal gets what was set, a pipe every setting.
    plain = [name for name, fields in settings.items() if fields["from"] == "default"]
    brief = plain if sys.stdout.isatty() else []
    for name, setting in settings.items():
        if name not in brief:
            show(f"  {name} = {_shown(setting['value'])}  ({_source(setting)})")
    if brief:
        show(*_wrapped(f"  by default: {', '.join(brief)}"))
    for name, text in faults.items():
        show(f"{name}: FAILS: {text}")
    return int(code)


def _wrapped(line: str) -> list[str]:
    """Return a list of many things as lines that fit the terminal; others stay in one line."""
    import textwrap

    if line.count(", ") < _MANY:
        return [line]
    return textwrap.wrap(
        line,
        max(60, terminal_width()),
        subsequent_indent="  ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _look(
    found: dict[str, str], faults: dict[str, str], name: str, look: Callable[[], str]
) -> None:
    """Note what a look finds; what it raises is the finding, whatever it is."""
    try:
        found[name] = look()
    except (ImportError, AttributeError, OSError, RuntimeError, ValueError, TypeError) as error:
        faults[name] = f"{type(error).__name__}: {error}"


def _packages(found: dict[str, str], faults: dict[str, str]) -> None:
    """Note the versions of all packages that can be imported, and each that cannot."""
    versions = []
    for name in needed():
        try:
            versions.append(f"{name} {version_of(name)}")
        except DependencyError as error:
            faults[name] = error.message
    found["packages"] = ", ".join(versions)


def _engine() -> str:
    from tracerisk.twin.physics.physics import engine

    return engine()


def _physics() -> str:
    from tracerisk.twin.simulation.twin import Twin

    robot = load_robot(robot_names()[0])
    if robot.default_scene is None:
        return "no scene to step"
    twin = Twin.build(robot, load_scene(robot.default_scene))
    twin.advance(10 * twin.step_ns)
    return f"{robot.name} in {robot.default_scene} built and stepped"


def _robots() -> str:
    return ", ".join(robot_names())


def _sandbox() -> str:
    """Return which parts of the sandbox work here."""
    here = support()
    parts = {
        "files": here.landlock > 0,
        "network and other calls": here.seccomp,
        "ports": here.landlock >= 4,
        "devices": here.landlock >= 5,
        "signals": here.landlock >= 6 or here.seccomp,
        "memory of all its processes at once": group_folder() is not None,
        "loopback": not here.missing and offers_own_network(),
    }
    version = f"Landlock {here.landlock}" if here.landlock else "no Landlock"
    filters = "seccomp" if here.seccomp else "no seccomp"
    kept = ", ".join(name for name, is_kept in parts.items() if is_kept)
    if not here.missing:
        return f"works ({version}, {filters}); kept in: {kept}"
    return f"does not work: {here.missing} is missing ({version}, {filters})"


def _of_environment() -> str:
    """Return where packages are installed for a controller of either ROS in this folder."""
    here = Project(Path.cwd())
    of_both = (here.prefixes(1, Settings()), here.prefixes(2, Settings()))
    return _installed(tuple(dict.fromkeys(prefix for prefixes in of_both for prefix in prefixes)))


def _installed(prefixes: Sequence[Prefix]) -> str:
    """Return the prefixes in their order, each with how many packages it has and what names it.

    Those of one workspace that has a prefix for each package are one.
    """
    groups: dict[tuple[str, str], list[Prefix]] = {}
    for prefix in prefixes:
        parent = Path(prefix.path).parent
        shown = str(parent) if parent.name == "install" else prefix.path
        groups.setdefault((shown, prefix.found_in), []).append(prefix)
    parts = []
    for (shown, found_in), group in groups.items():
        count = len(installed_packages(group))
        packages = "1 package" if count == 1 else f"{count} packages"
        parts.append(f"{shown} ({found_in}): {packages}")
    return "; ".join(parts) or "none: no variable, setting or folder names one"


def _settings(
    controller: Controller, settings: Settings, given: Mapping[str, str | None]
) -> dict[str, dict[str, Any]]:
    """Return each setting of a controller: its value, where it comes from, and the place there."""
    shown = {}
    for name, origin in controller.project.setting_origins(controller.file).items():
        place = origin.location
        source = "default" if place is None else "controller" if origin.is_own else "all"
        if given.get(name) is not None:
            source, place = "command line", None
        shown[name] = {
            "value": getattr(settings, name),
            "from": source,
            "file": None if place is None else os.path.relpath(place.file),
            "line": None if place is None else place.line,
        }
    return shown


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(value) if value else "none"
    if isinstance(value, bool):
        return str(value).lower()
    return "none" if value is None else str(value)


def _source(setting: Mapping[str, Any]) -> str:
    if setting["file"] is None:
        return str(setting["from"])
    given = "all controllers"
    if setting["from"] == "controller":
        in_table = setting["file"].endswith(".toml")
        given = "the controller's own table" if in_table else "the controller itself"
    return f"{setting['file']}:{setting['line']}, {given}"


_MOST_EVIDENCE = 12


def _of_controller(controller: Controller, settings: Settings) -> dict[str, str]:
    from tracerisk.pipeline.launch.choose import LaunchChoice, choose_launch
    from tracerisk.pipeline.robot.choice import choose_launched_robot

    of_controller = {"controller": controller.file, "root": str(controller.root)}
    if controller.is_python:
        distro = choose_distro(controller, settings)
        assumed = "assumed: " if distro.is_assumed else ""
        of_controller["ros_distro"] = f"{distro.name} ({assumed}{distro.found_in})"
        of_controller["installed ROS"] = _installed(prefixes_of(controller, settings))
        absent = [name for name in settings.ros_prefixes if not Path(name).is_dir()]
        if absent:
            of_controller["ros_prefixes that are not there"] = ", ".join(absent)
    launch = LaunchChoice()
    try:
        launch = choose_launch(controller, settings)
        text = "; ".join(note.removeprefix("launch: ") for note in launch.notes)
        of_controller["launch"] = text or "nothing from a launch file"
    except LimitError:
        raise
    except TraceRiskError as error:
        of_controller["launch"] = f"not known: {error}"
    try:
        choice = choose_launched_robot(controller, settings, launch)
        robot = choice.robot
        # Where it is assumed, that says as well why it is this one.
        said = [] if robot.chosen_by in robot.doubt else [robot.chosen_by]
        said += ["some figures are assumed"] if robot.approximate else []
        of_controller["robot"] = robot.name + (f" ({'; '.join(said)})" if said else "")
        if robot.doubt:
            of_controller["robot assumed"] = robot.doubt
        if choice.evidence:
            of_controller["what speaks for robots"] = "; ".join(
                map(str, choice.evidence[:_MOST_EVIDENCE])
            )
        of_controller.update(_parts(robot))
        if choice.files:
            of_controller["robot files read"] = ", ".join(map(str, choice.files))
        if choice.skipped:
            of_controller["robot files not taken"] = "; ".join(choice.skipped)
        of_controller["scene"] = settings.scene or robot.default_scene or "none; give --scene"
        of_controller["hardware"] = api.load_hardware(settings, robot.name).file
    except LimitError:
        raise
    except TraceRiskError as error:
        of_controller["robot"] = f"not known: {error}"
    return of_controller


def _parts(robot: Robot) -> dict[str, str]:
    """Return what there is of a robot that a controller can name."""
    states = (
        f"{group}: {', '.join(names)}" for group, names in robot.named_states.items() if names
    )
    motors = (
        f"{joint.name} {joint.lower:.4g} to {joint.upper:.4g}, {joint.velocity_limit:.4g}/s, "
        f"{joint.torque_limit:.4g} {'N' if joint.type == 'prismatic' else 'N m'}"
        for joint in robot.arm_joints
    )
    bare = [link.name for link in robot.links if not link.shapes and link.mass > 0.0]
    return {
        "joints": "; ".join(motors),
        "groups": "; ".join(
            f"{name}: {', '.join(group.joints)}" for name, group in robot.groups.items()
        ),
        "named states": "; ".join(states) or "none",
        "grippers": "; ".join(
            f"{gripper.name}: {', '.join(gripper.joints)}" for gripper in robot.grippers
        )
        or "none",
        "links without a shape": ", ".join(bare) or "none",
    }
