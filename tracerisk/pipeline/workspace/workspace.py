"""The ROS workspace around a controller: its packages, importable as if they were built."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from tracerisk.common.text.bounded import MOST_BYTES, files_below, in_folder
from tracerisk.config import PACKAGE_FILE, RosDistro, Settings
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.package_folders import (
    ENVIRONMENT,
    NOT_SEARCHED,
    REPOSITORY,
    SOURCES,
    declared_needs,
    head_of,
    is_of_other_ros,
    name_of,
    needed_beside,
    packages_below,
    ros_of_package,
    siblings_of,
)
from tracerisk.pipeline.workspace.prefixes import Prefix, installed_packages
from tracerisk.ros.messages.interface_texts import shipped_packages

_INTERFACES = ("msg", "srv", "action")
TESTS = frozenset({"test", "tests"})
_UPWARDS = 4
_TOP_FILES = ("readme", "licence", "license")
_TOP_MARKS = frozenset(
    {".catkin_workspace", ".catkin_tools", ".github", ".gitignore", ".gitlab-ci.yml", ".gitmodules",
     ".rosinstall", ".travis.yml", "colcon.meta"}
)  # fmt: skip
_MOST_MODULES = 300
_MOST_FOLDERS = 5000
_WORD = re.compile(r"[\w.-]+")
DISTROS: Mapping[RosVersion, tuple[RosDistro, ...]] = {1: ("noetic",), 2: ("humble", "jazzy")}
"""The distributions of each ROS that are served."""
_LAUNCH_ENDINGS = (".launch", ".py", ".xml", ".yaml")


@dataclass(frozen=True, slots=True)
class Workspace:
    """The packages that can be seen from a controller: each name and the folder it is in."""

    packages: Mapping[str, Path]
    """Those of the controller's own workspace."""
    prefixes: tuple[Prefix, ...] = ()
    """Where other packages are installed, in the order in which they count."""

    @property
    def installed(self) -> dict[str, Path]:
        """The packages of the prefixes that the workspace does not have itself."""
        paths = installed_packages(self.prefixes)
        return {name: folder for name, folder in paths.items() if name not in self.packages}

    @property
    def findable(self) -> dict[str, Path]:
        """All packages that can be asked for by their names: its own and the installed ones."""
        return {**self.packages, **self.installed}

    @property
    def interfaces(self) -> dict[str, Path]:
        """The packages that hold messages, services or actions of their own."""
        return {
            name: folder
            for name, folder in self.packages.items()
            if any(files_below(folder / kind, f".{kind}") for kind in _INTERFACES)
        }

    @property
    def import_paths(self) -> tuple[Path, ...]:
        """The folders that a build would put on the import path: `<package>/src`."""
        return tuple(
            folder / "src" for folder in self.packages.values() if (folder / "src").is_dir()
        )

    @property
    def python_packages(self) -> dict[str, Path]:
        """The Python packages of ROS packages, direct or in `src`, and the folder each is in."""
        paths: dict[str, Path] = {}
        folders = [*self.packages.items(), *((folder.name, folder) for folder in self.import_paths)]
        for name, folder in folders:
            for path in in_folder(folder):
                is_python = (path / "__init__.py").is_file() and path.name not in TESTS
                if is_python or (path.name == name and in_folder(path, ".py")):
                    paths.setdefault(path.name, folder)
        return paths

    def folder_of_module(self, name: str, root: Path) -> Path | None:
        """Return the folder of a module that stands off the import path, `None` for none.

        Some packages install modules where only their own set-up finds them. What stands below
        `root` goes before the rest of the workspace; of several the one whose path sorts first.
        """
        for folders in ([root.resolve()], list(self.packages.values())):
            paths = [path for folder in folders for path in _modules_named(name, folder)]
            if paths:
                return min(paths, key=lambda path: (len(path.parts), path))
        return _folder_above(name, root.resolve())


def searched(
    top: Path, left_out: Collection[str] = NOT_SEARCHED, *, environments: bool = True
) -> Iterator[tuple[str, list[str]]]:
    """Yield the folders below one with the names of their files, in order.

    Hidden folders and those `left_out` are not entered, nor are environments of Python if not so.
    Pipes, sockets and devices are left out: opening a pipe blocks until something writes to it.
    """
    waiting = [str(top)]
    while waiting:
        folder = waiting.pop()
        try:
            with os.scandir(folder) as listed:
                entries = sorted(listed, key=lambda dir_entry: dir_entry.name)
        except OSError:
            continue
        files = [entry.name for entry in entries if _is_file(entry)]
        if not environments and ENVIRONMENT in files:
            continue
        yield folder, files
        waiting += [
            entry.path
            for entry in reversed(entries)
            if entry.is_dir(follow_symlinks=False)
            and not entry.name.startswith(".")
            and entry.name not in left_out
        ]


def _is_file(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_file()
    except OSError:  # a link to itself
        return False


def _modules_named(name: str, top: Path) -> Iterator[Path]:
    """Yield the folders below `top` that hold the module or package `name`."""
    for folder, files in itertools.islice(searched(top, NOT_SEARCHED | TESTS), _MOST_FOLDERS):
        if f"{name}.py" in files or Path(folder, name, "__init__.py").is_file():
            yield Path(folder)


def _folder_above(name: str, root: Path) -> Path | None:
    """Return the folder from which a project is started, where that makes `name` importable.

    `python -m src.pick` and `PYTHONPATH=.` do so: it is the root, or one above it up to the top of
    the repository. A package there needs no `__init__.py`.
    """
    above = itertools.takewhile(lambda folder: folder != Path.home(), root.parents)
    folders = (root, *itertools.islice(above, _UPWARDS))
    top = next((number for number, folder in enumerate(folders) if _is_marked(folder)), 0)
    for folder in folders[: top + 1]:
        if (folder / f"{name}.py").is_file() or _holds_python(folder / name):
            return folder
    return None


def _holds_python(folder: Path) -> bool:
    return any(path.suffix == ".py" or in_folder(path, ".py") for path in in_folder(folder))


def workspace_of(controller: Controller, settings: Settings) -> Workspace:
    """Return the packages around a controller, and those that are installed for its ROS.

    A package of its workspace that is built for the other ROS gives way to one that is installed,
    or whose messages are shipped, for its own.
    """
    workspace, prefixes = controller.workspace, prefixes_of(controller, settings)
    ros = controller.ros_version
    other = {name for name, folder in workspace.packages.items() if is_of_other_ros(folder, ros)}
    if other:
        # Only then: to list them all may take a moment.
        installed = installed_packages(prefixes).items()
        there = {name for name, folder in installed if not is_of_other_ros(folder, ros)}
        other &= there.union(*map(shipped_packages, DISTROS[ros]))
    packages = {name: folder for name, folder in workspace.packages.items() if name not in other}
    return Workspace(packages, prefixes)


def prefixes_of(controller: Controller, settings: Settings) -> tuple[Prefix, ...]:
    """Return where packages are installed for the ROS of a controller."""
    return controller.project.prefixes(controller.ros_version, settings)


def find_workspace(root: Path, top: Path, ros: RosVersion | None = None) -> Workspace:
    """Return the packages below a controller's root and, where that is one itself, around it.

    `top` is the one that `project_top` gives.
    A root that is no package has those around it where it lies in the `src` of a workspace, or
    beside that in the same repository.

    Looked for upwards within the repository; without one, at most four folders up. Then it is
    the folder `src` of a workspace, or the nearest folder with what lies at the top of a
    repository (a readme, a licence, ...). Where there is neither, what lies beside a package is
    none of its own but for the packages that it depends on. So do those of the other repositories
    in the same `src`.
    Packages at any depth are found. The search begins at `root` and goes on upwards, so that what
    a very large project has in other places is left out first.
    Where two packages have one name, one that is not built for the other ROS than `ros` wins, else
    the one that contains `root` or is nearest to it. Without `ros` it is that of the package of
    `root`.
    """
    ros = ros or ros_of_package(root)
    packages: dict[str, Path] = {}

    def rank(folder: Path) -> tuple[bool, int]:
        return is_of_other_ros(folder, ros), _apart(folder, root.resolve())

    for folder in packages_below(top, first=root.resolve()):
        known = packages.setdefault(name_of(folder), folder)
        if known != folder and rank(folder) < rank(known):
            packages[name_of(folder)] = folder
    is_package = (root / PACKAGE_FILE).is_file()
    siblings = siblings_of(root.resolve(), top)
    is_alone = is_package and top == root.resolve() and not (top / REPOSITORY).exists()
    if siblings is not None or is_alone:
        beside = needed_beside(root.resolve(), siblings, ros)
        own = {name for name in packages if not is_of_other_ros(packages[name], ros)}
        better = {
            name: folder
            for name, folder in beside.items()
            if name not in own and not is_of_other_ros(folder, ros)
        }
        packages = {**beside, **packages, **better}
    if is_package:
        packages[name_of(root.resolve())] = root.resolve()
    return Workspace(dict(sorted(packages.items())))


def _apart(one: Path, other: Path) -> int:
    """Return how many folders lie between two folders."""
    shared = len(os.path.commonpath((one, other)).rstrip("/").split("/"))
    return len(one.parts) + len(other.parts) - 2 * shared


def packages_in(strings: Iterable[str]) -> frozenset[str]:
    """Return the words of strings that may be names of packages."""
    return frozenset(word for string in strings for word in _WORD.findall(string))


def named_packages(
    root: Path, packages: Mapping[str, Path], strings: Iterable[str]
) -> frozenset[str]:
    """Return the packages that a controller's `strings`, launch files or manifest name.

    The package of `root` is one of them.
    """
    words = set(packages_in(strings))
    files = files_below(root, *_LAUNCH_ENDINGS, left_out=NOT_SEARCHED)
    for file in [file for file in files if "launch" in file.name][:_MOST_MODULES]:
        words.update(_WORD.findall(head_of(file, MOST_BYTES)))
    if (root / PACKAGE_FILE).is_file():
        words.update((*declared_needs(root), name_of(root)))
    return frozenset(words & packages.keys())


def project_top(root: Path) -> Path:
    """Return the folder whose files belong to one project with the controller in `root`."""
    root = root.resolve()
    if (root / REPOSITORY).exists():
        return root
    above = list(
        itertools.takewhile(lambda folder: folder not in (Path.home(), Path("/")), root.parents)
    )
    height = next(
        (number for number, folder in enumerate(above) if (folder / REPOSITORY).exists()), None
    )
    # Within a repository nothing is too far away.
    upwards = above[:_UPWARDS] if height is None else above[: height + 1]
    if not (root / PACKAGE_FILE).is_file():
        # A script in no package may lie among those of a workspace all the same.
        sources = next((upward for upward in upwards if upward.name == SOURCES), None)
        if sources is None:
            # Or beside its folder `src`.
            top = next((upward for upward in upwards if _is_marked(upward)), root)
            return top if any(packages_below(top / SOURCES)) else root
        if not any(packages_below(sources)):
            return root
        return sources.parent if _is_marked(sources.parent) else sources
    if height is not None:
        return above[height]
    for folder in upwards:
        if _is_marked(folder):
            return folder
        if folder.name == SOURCES:
            return folder.parent if _is_marked(folder.parent) else folder
    return root


def _is_marked(folder: Path) -> bool:
    """Return whether a folder looks like the top of a repository or of a workspace."""
    try:
        with os.scandir(folder) as entries:
            names = {entry.name.lower() for entry in entries}
    except OSError:
        return False
    return bool(names & _TOP_MARKS) or any(name.startswith(_TOP_FILES) for name in names)
