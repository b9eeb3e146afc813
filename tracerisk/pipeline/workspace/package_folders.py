"""Folders of ROS packages in sources: those that have a `package.xml`, and their names.

Some lie beside the controller's project, in other repositories in the `src` of its workspace. What
the controller needs of them is of its own workspace (`needed_beside`); the rest fills in what is
absent (`prefixes.py`), for unrelated ones may be collected in such a folder too.
"""

from __future__ import annotations

import itertools
import os
import re
import stat
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.common.sandbox.files.noted_reads import unnoted
from tracerisk.common.text.bounded import MOST_BYTES, files_below
from tracerisk.config import PACKAGE_FILE
from tracerisk.instrument.source.ros_version import RosVersion, build_tools

NOT_SEARCHED = frozenset({"build", "devel", "install", "log", "node_modules", "__pycache__"})
ENVIRONMENT = "pyvenv.cfg"
"""The file at the top of an environment of Python."""
MOST_ENTRIES = 50_000
"""How many files and folders a search for packages looks at."""
LONGEST_SEARCH_S = 10.0
"""How long a search for packages takes: folders may lie on a slow disk [s]."""

REPOSITORY = ".git"
"""The folder that the top of a repository has."""
SOURCES = "src"
"""The folder in which a workspace keeps its packages."""

_ABOVE = 2  # folders above a project in which its `src` may be
_MOST_BESIDE = 100
_DEEPEST_BESIDE = 4  # repository, stack, family, package
_MOST_SEEN_BESIDE = 20_000
_MOST_MODULES = 300
_IMPORT = re.compile(r"^[ \t]*(?:from|import)[ \t]+(\w+)", re.MULTILINE)
_IGNORED_MARKS = ("COLCON_IGNORE", "CATKIN_IGNORE", "AMENT_IGNORE")
_MOST_BYTES = 256 * 1024
_NAME = re.compile(r"<name>\s*([\w.-]+)\s*</name>")
_NEED = re.compile(r"<(?:\w+_)?depend\b[^>]*>\s*([\w.-]+)\s*<")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


def packages_below(
    top: Path,
    deepest: int | None = None,
    first: Path | None = None,
    most: int | None = None,
) -> Iterator[Path]:
    """Yield the folders with a `package.xml`, none inside another.

    Those in and beside `first`, a folder below `top`, come before others, then the nearer to the
    top. The search ends after `most` entries, `MOST_ENTRIES` if not given, or
    `LONGEST_SEARCH_S`.
    """
    waiting = deque([(top, 0)])
    if first is not None and first != top and first.is_relative_to(top):
        depth = len(first.parts) - len(top.parts)
        around = [first, *first.parents[: depth - 1]]
        waiting.extendleft((folder, len(folder.parts) - len(top.parts)) for folder in around[::-1])
    seen: set[Path] = set()
    entries_left = MOST_ENTRIES if most is None else most
    ends_at = time.monotonic() + LONGEST_SEARCH_S
    while waiting and entries_left > 0 and time.monotonic() < ends_at:
        folder, depth = waiting.popleft()
        if folder in seen:
            continue
        seen.add(folder)
        try:
            with os.scandir(folder) as entries:
                listed = sorted(
                    itertools.islice(entries, entries_left), key=lambda entry: entry.name
                )
        except OSError:
            continue
        entries_left -= len(listed)
        names = {entry.name for entry in listed}
        if names.intersection(_IGNORED_MARKS) or ENVIRONMENT in names:
            continue
        if PACKAGE_FILE in names:
            yield folder
            continue
        if deepest is None or depth < deepest:
            waiting += [
                (folder / entry.name, depth + 1)
                for entry in listed
                if entry.is_dir(follow_symlinks=False)
                and not entry.name.startswith(".")
                and entry.name not in NOT_SEARCHED
            ]


def name_of(folder: Path) -> str:
    """Return the name of the package in a folder: by its manifest, else the folder's."""
    matched = _NAME.search(manifest_text(folder))
    return matched[1] if matched else folder.name


def ros_of_package(folder: Path) -> RosVersion | None:
    """Return the ROS for which the manifest in a folder has its package built.

    catkin builds for ROS 1, ament for ROS 2. `None` where it names neither, or both.
    """
    tools = build_tools(_COMMENT.sub("", manifest_text(folder)))
    if len(tools) != 1:
        return None
    return 2 if "ament" in tools else 1


def is_of_other_ros(folder: Path, ros: RosVersion | None) -> bool:
    """Return whether the package in a folder is built for the other ROS than a given one."""
    return ros is not None and ros_of_package(folder) not in (None, ros)


def declared_needs(folder: Path) -> tuple[str, ...]:
    """Return the packages on which the manifest in a folder says that its package depends."""
    return tuple(_NEED.findall(manifest_text(folder)))


def manifest_text(folder: Path) -> str:
    """Return the first 256 kB of the `package.xml` in a folder; empty where it is not a file."""
    return head_of(folder / PACKAGE_FILE, _MOST_BYTES)


def head_of(path: Path, most: int) -> str:
    """Return the first bytes of a file, at most `most`, as a text; empty where it is not a file.

    It is no input of a run: to find what a run uses, all around it are looked through.
    """
    try:
        # A pipe, which Windows has in no folder, would keep who opens it waiting.
        with unnoted():
            descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        with os.fdopen(descriptor, "rb") as stream:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                return ""
            return stream.read(most).decode("utf-8", errors="replace")
    except OSError:
        return ""


@dataclass(frozen=True, slots=True)
class Siblings:
    """The place of a project in the `src` of a workspace."""

    project: Path
    """The top of the controller's repository or, without one, of its project."""
    sources: Path
    """The folder `src` above it."""

    @property
    def folders(self) -> Iterator[Path]:
        """The folders beside the project, on its level and on those above up to `src`."""
        height = list(self.project.parents).index(self.sources)
        above = self.project.parents[: height + 1]
        own = {self.project, *above}
        generator = (folder / name for folder in above for name in _folders_in(folder))
        for folder in itertools.islice(generator, _MOST_BESIDE):
            if folder not in own and folder.name not in NOT_SEARCHED:
                yield folder


def siblings_of(root: Path, top: Path) -> Siblings | None:
    """Return what is beside the project of `root`, whose top is `top`; `None` in no `src`."""
    above = itertools.takewhile(
        lambda folder: folder not in (Path.home(), Path("/")), (root, *root.parents)
    )
    project = next((folder for folder in above if (folder / REPOSITORY).exists()), top)
    sources = next((folder for folder in project.parents[:_ABOVE] if folder.name == SOURCES), None)
    return None if sources is None else Siblings(project, sources)


def packages_of_sibling(folder: Path) -> Iterator[Path]:
    """Yield the packages of a folder beside a project."""
    yield from packages_below(folder, _DEEPEST_BESIDE, most=_MOST_SEEN_BESIDE)


def needed_beside(root: Path, siblings: Siblings | None, ros: RosVersion | None) -> dict[str, Path]:
    """Return the packages beside `root` that it needs, and those that these need.

    Besides what is around it in two folders, they are those of the `siblings` of its project. Of
    several with one name, those that are built for the other ROS than `ros` come last.
    """
    beside: dict[str, Path] = {}
    around = (folder for folder in root.parents[:_ABOVE] if folder not in (Path.home(), Path("/")))
    near = (package for folder in around for package in packages_below(folder, deepest=_ABOVE))
    far = (
        package
        for folder in (siblings.folders if siblings is not None else ())
        for package in packages_of_sibling(folder)
    )
    for package in (*near, *far):
        known = beside.setdefault(name_of(package), package)
        if known != package and is_of_other_ros(known, ros):
            beside[name_of(package)] = package
    paths: dict[str, Path] = {}
    waiting = [root]
    while waiting:
        for name in _needs_of(waiting.pop()):
            if name in beside and name not in paths and beside[name] != root:
                paths[name] = beside[name]
                waiting.append(beside[name])
    return paths


def imported_names(source: str) -> frozenset[str]:
    """Return the first part of each module that the lines of a source import."""
    return frozenset(_IMPORT.findall(source))


def _needs_of(folder: Path) -> list[str]:
    """Return what a package says it needs, and what its modules import without saying so."""
    modules = files_below(folder, ".py", left_out=NOT_SEARCHED)[:_MOST_MODULES]
    imported = {name for module in modules for name in imported_names(head_of(module, MOST_BYTES))}
    return [*declared_needs(folder), *sorted(imported)]


def _folders_in(folder: Path) -> list[str]:
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if not entry.name.startswith(".")]
    except OSError:
        return []
    return sorted(name for name in names if (folder / name).is_dir())
