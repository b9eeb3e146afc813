"""Which distribution of ROS a controller is written for, by what its workspace names."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.common.text.bounded import file_text, in_folder, regular_file
from tracerisk.config import PACKAGE_FILE, RosDistro, Settings
from tracerisk.errors import SettingsError
from tracerisk.instrument.source.python_2 import is_only_python_3
from tracerisk.instrument.source.python_source import is_python_2
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.workspace import DISTROS, searched

_SERVED: dict[RosVersion, dict[str, RosDistro]] = {
    1: {
        **dict.fromkeys(("indigo", "jade", "kinetic", "lunar", "melodic"), "noetic"),
        "noetic": "noetic",
    },
    2: {
        **dict.fromkeys(("dashing", "eloquent", "foxy", "galactic", "humble", "iron"), "humble"),
        **dict.fromkeys(("jazzy", "kilted", "lyrical", "rolling"), "jazzy"),
    },
}
"""Every distribution that may be named, and the one of those served whose rules are nearest."""
_ASSUMED: dict[RosVersion, RosDistro] = {1: "noetic", 2: "jazzy"}
_INSTALLED = Path("/opt/ros")
_HIDDEN = (".github", ".gitlab", ".circleci", ".devcontainer", ".docker", ".ci")
_MOST_FOLDERS = 500
_MOST_BYTES = 200_000
_SHOWN = 3

_NAMES = "|".join(name for names in _SERVED.values() for name in names)
_WORD = re.compile(rf"(?<![a-z])({_NAMES})(?![a-z])")
# Prose has `rolling`, `iron` and `humble` as words of its own.
_IN_PROSE = re.compile(
    rf"(?:\bros(?:[ _-]?[12])?[ _:/-]{{1,2}}|/opt/ros/|ros_?distro\W{{1,6}}|moveit/moveit2?:)"
    rf"({_NAMES})(?![a-z])"
)
_POINTS = {"image": 4, "checks": 3, "branch": 3, "sources": 2, "commands": 2, "prose": 1}
"""How much a file of a kind that names a distribution weighs."""


@dataclass(frozen=True, slots=True)
class DistroChoice:
    """The distribution of ROS whose rules a run follows, and why."""

    name: RosDistro
    """The distribution, one of those that are served."""
    found_in: str
    """Where it was found, or why it is assumed, in words."""
    is_assumed: bool = False
    """Whether nothing says so: nobody names one, several are named alike, or one not served."""
    precedes_noetic: bool = False
    """Whether the controller is for a ROS 1 before Noetic, as far as anything says."""
    follows_jazzy: bool = False
    """Whether the workspace names a ROS 2 after Jazzy, which stands for it."""

    @property
    def assumption(self) -> str:
        """The line among the assumptions of a run; empty where nothing is assumed."""
        return f"ros_distro: {self.name}, {self.found_in}" if self.is_assumed else ""


@dataclass(frozen=True, slots=True)
class _Mention:
    name: str
    """The distribution as it is written."""
    points: int
    """How much it weighs."""
    place: str
    """The file and line, from the top of the project."""
    is_of_others: bool = False
    """Whether it stands among packages beside the controller's, which may be others' work."""


def choose_distro(
    controller: Controller,
    settings: Settings,
    environment: Mapping[str, str] = os.environ,
    installed: Path = _INSTALLED,
) -> DistroChoice:
    """Return the distribution of a controller: by its settings, its workspace, the installed ROS.

    Raises:
        SettingsError: the setting is a distribution of the other ROS than the controller's.
    """
    ros = controller.ros_version
    if settings.ros_distro is not None:
        if settings.ros_distro not in DISTROS[ros]:
            origin = controller.project.setting_origins(controller.file).get("ros_distro")
            allowed = " or ".join(DISTROS[ros])
            raise SettingsError(
                f"ros_distro: {settings.ros_distro} is not of ROS {ros}, which {controller.file} "
                f"imports; give {allowed} in its own table",
                None if origin is None else origin.location,
            )
        return DistroChoice(settings.ros_distro, "by the settings")
    found = _mentions(controller.project.top, controller.path.resolve())
    mentions = [mention for mention in found if mention.name in _SERVED[ros]]
    own = [mention for mention in mentions if not mention.is_of_others]
    mentions = own or mentions
    if not mentions:
        sourced = _of_installed(environment, installed)
        mentions = [mention for mention in sourced if mention.name in _SERVED[ros]]
    choice = _weighed(ros, mentions)
    if ros == 2 or not choice.is_assumed or not controller.is_python:
        return choice
    if is_python_2(controller.source):
        of_source = f"the nearest that is served to {controller.file}, which is Python 2"
        found_in = choice.found_in if mentions else of_source
        return replace(choice, found_in=found_in, precedes_noetic=True)
    # All that is named is older, but nothing runs there that Python 2 cannot read.
    tree = controller.tree
    is_older = bool(mentions) and tree is not None and not is_only_python_3(tree)
    return replace(choice, precedes_noetic=is_older)


def _weighed(ros: RosVersion, mentions: list[_Mention]) -> DistroChoice:
    """Return the distribution that most speaks for; of several alike the newest."""
    served = _SERVED[ros]
    points: dict[RosDistro, int] = {}
    for mention in mentions:
        name = served[mention.name]
        points[name] = points.get(name, 0) + mention.points
    if not points:
        return DistroChoice(_ASSUMED[ros], "nothing in the workspace names one", is_assumed=True)
    order = list(dict.fromkeys(served.values()))
    best = max(points, key=lambda name: (points[name], order.index(name)))
    chosen = [mention for mention in mentions if served[mention.name] == best]
    words = ", ".join(dict.fromkeys(mention.place for mention in chosen[:_SHOWN]))
    others = [name for name, item in points.items() if name != best and item == points[best]]
    if others:
        return DistroChoice(best, f"named as often as {others[0]}: {words}", is_assumed=True)
    written = sorted({mention.name for mention in chosen})
    if best not in written:
        nearest = f"the nearest that is served to {' and '.join(written)}: {words}"
        is_later = best == "jazzy"
        return DistroChoice(best, nearest, is_assumed=True, follows_jazzy=is_later)
    return DistroChoice(best, words)


def _mentions(top: Path, controller: Path) -> Iterator[_Mention]:
    """Yield what the files of a project say, one a file and distribution."""
    yield from _of_branch(top)
    packages: list[Path] = []
    files_of_kind: list[tuple[Path, str]] = []
    tops = [top, *(top / name for name in _HIDDEN if (top / name).is_dir())]
    for start in tops:
        for folder, files in itertools.islice(searched(start, environments=False), _MOST_FOLDERS):
            if PACKAGE_FILE in files and Path(folder) not in controller.parents:
                packages.append(Path(folder))
            paths = (Path(folder, file) for file in files)
            files_of_kind += [(path, kind) for path in paths if (kind := _kind(path, top))]
    # What lies above such a package and not above the controller comes with the package.
    others = {
        folder
        for package in packages
        for folder in (package, *package.parents)
        if folder not in controller.parents
    }
    for path, kind in files_of_kind:
        yield from _of_file(path, top, kind, is_of_others=not others.isdisjoint(path.parents))


def _kind(path: Path, top: Path) -> str:
    """Return which kind of file may name a distribution; empty for none."""
    name = path.name.lower()
    inside = path.relative_to(top).parts[0]
    if "dockerfile" in name or name.startswith(("containerfile", "docker-compose", "compose.y")):
        return "image"
    if inside == ".devcontainer" and name.endswith(".json"):
        return "image"
    is_yaml = name.endswith((".yml", ".yaml"))
    if inside in _HIDDEN or name in (".gitlab-ci.yml", ".travis.yml", "jenkinsfile"):
        return "checks" if is_yaml or name == "jenkinsfile" else ""
    if name.endswith((".repos", ".rosinstall")):
        return "sources"
    if name.endswith((".sh", ".bash", ".zsh")) or name in ("makefile", "justfile"):
        return "commands"
    return "prose" if name.startswith("readme") else ""


def _of_file(path: Path, top: Path, kind: str, *, is_of_others: bool) -> Iterator[_Mention]:
    try:
        with regular_file(path) as stream:
            text = stream.read(_MOST_BYTES).decode("utf-8", "replace").lower()
    except OSError:
        return
    seen = set()
    found_by = _IN_PROSE if kind in ("prose", "commands") else _WORD
    for number, line in enumerate(text.split("\n"), start=1):
        if kind != "prose" and line.lstrip().startswith("#"):
            continue
        for name in found_by.findall(line):
            if name not in seen:
                seen.add(name)
                place = f"{path.relative_to(top).as_posix()}:{number}"
                yield _Mention(name, _POINTS[kind], place, is_of_others)


def _of_branch(top: Path) -> Iterator[_Mention]:
    """Yield the distribution that the branch which is checked out is named after."""
    try:
        head = file_text(top / ".git" / "HEAD", errors="replace").strip()
    except OSError:
        return
    branch = head.removeprefix("ref: refs/heads/")
    for name in _WORD.findall(branch.lower()):
        yield _Mention(name, _POINTS["branch"], f"the branch {branch}")


def _of_installed(environment: Mapping[str, str], installed: Path) -> Iterator[_Mention]:
    """Yield the distribution that is sourced, and those that are installed."""
    sourced = environment.get("ROS_DISTRO", "").lower()
    if sourced:
        yield _Mention(sourced, 2, "the environment's ROS_DISTRO")
    for folder in in_folder(installed):
        yield _Mention(folder.name.lower(), 1, str(folder))
