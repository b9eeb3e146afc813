"""The installed ROS and the overlays around a controller: their prefixes, and what is in them.

A prefix is a folder into which packages are installed: `share/PACKAGE`, `lib/python3.10/...`. They
count behind the controller's own workspace, the first that has a package wins: those of the setting
`ros_prefixes`, the `install` or `devel` of the controller's own workspace, those that the shell has
sourced, and the ROS in `/opt/ros`. A folder of ROS_PACKAGE_PATH holds packages in sources.
Last come the sources beside the controller's project in the same `src`: they fill in what is
absent.

Folders are listed, and of installed packages no file is read: there may be thousands.
"""

from __future__ import annotations

import itertools
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.common.sandbox.ros_prefix import (
    AMENT_INDEX,
    CATKIN_MARK,
    COLCON_PACKAGES,
    SHARE,
    is_prefix,
    prefix_folders,
)
from tracerisk.config import PACKAGE_FILE
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.pipeline.workspace.package_folders import (
    SOURCES,
    head_of,
    is_of_other_ros,
    name_of,
    packages_below,
    packages_of_sibling,
    siblings_of,
)

PREFIX_VARIABLES = ("AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "CMAKE_PREFIX_PATH")
"""The variables of the environment that list prefixes."""
SOURCES_VARIABLE = "ROS_PACKAGE_PATH"
"""The variable that lists folders below which packages are, in sources too."""
INSTALLED = Path("/opt/ros")
"""The folder of the distributions of ROS that are installed."""

_SETTING = "the setting ros_prefixes"
_SPACES = ("install", "devel")
_UPWARDS = 6
_MOST_PREFIXES = 5000
_MOST_PACKAGES = 20_000
_MOST_BYTES = 64 * 1024
_PACKAGE = re.compile(r"[A-Za-z][\w-]*")
_PYTHON = re.compile(r"python3(?:\.(\d+))?")
_KINDS = ("msg", "srv", "action")


@dataclass(frozen=True, slots=True)
class Prefix:
    """A folder with installed packages, and what names it."""

    path: str
    """The folder."""
    found_in: str
    """The variable, setting or place that names it, in words."""
    within: str = ""
    """The folder in which all that is taken of it must lie; empty where it may lie anywhere."""
    is_sources: bool = False
    """Whether packages are anywhere below it, and not in its `share`."""
    fills_in: bool = False
    """Whether nothing of it goes before what is provided without it."""
    ros: RosVersion | None = None
    """The ROS of the controller, of which a package in sources goes before one of the other."""


def find_prefixes(
    root: Path,
    top: Path,
    ros: RosVersion,
    named: Sequence[str] = (),
    distro: str | None = None,
    environment: Mapping[str, str] | None = None,
) -> tuple[Prefix, ...]:
    """Return the prefixes that count for a controller of one ROS, in the order in which they do.

    `top` is the folder of its project, of which nothing leads out. `named` are those of its
    settings. `distro` is the distribution of which the installed ROS is taken first.
    """
    environment = os.environ if environment is None else environment
    prefixes: dict[str, Prefix] = {}
    candidates = itertools.chain(
        (Prefix(path, _SETTING) for path in named),
        _beside(root.resolve(), top.resolve()),
        _of_environment(environment, ros),
        _of_system(environment, ros, distro),
        _sources_beside(root.resolve(), top.resolve()),
    )
    for candidate in candidates:
        for prefix in _parts(candidate):
            key = os.path.realpath(prefix.path)
            if key not in prefixes and _ros_of(prefix) in (None, ros):
                prefixes[key] = replace(prefix, ros=ros) if prefix.is_sources else prefix
            if len(prefixes) >= _MOST_PREFIXES:
                return tuple(prefixes.values())
    return tuple(prefixes.values())


def _beside(root: Path, top: Path) -> Iterator[Prefix]:
    """Yield the `install` and `devel` of the workspace in whose `src` a controller lies.

    One that lies in a prefix itself, as it is installed, has that prefix and those beside it.
    """
    for folder in (root, *root.parents[:_UPWARDS]):
        if is_prefix(folder):
            # Each package has a prefix of its own in an isolated `install`.
            is_one_of_many = folder.parent.name in _SPACES
            at = folder.parent if is_one_of_many else folder
            found_in = "the prefix in which the controller is installed"
            yield Prefix(str(folder), found_in, within=str(at.parent))
            if is_one_of_many:
                yield Prefix(str(at), found_in, within=str(at.parent))
            break
    sources = (parent for parent in (root, *root.parents[:_UPWARDS]) if parent.name == SOURCES)
    workspaces = dict.fromkeys((*(source.parent for source in sources), top))
    for workspace in workspaces:
        if workspace in (Path.home(), Path("/")):
            continue
        for name in _SPACES:
            found_in = f"the folder {name} of the workspace"
            yield Prefix(str(workspace / name), found_in, within=str(workspace))


def _sources_beside(root: Path, top: Path) -> Iterator[Prefix]:
    """Yield what lies beside the folder of a project in the `src` of its workspace."""
    siblings = siblings_of(root, top)
    for folder in () if siblings is None else siblings.folders:
        found_in = "beside the project in the folder src of the workspace"
        yield Prefix(str(folder), found_in, within=str(folder), is_sources=True, fills_in=True)


def _of_environment(environment: Mapping[str, str], ros: RosVersion) -> Iterator[Prefix]:
    for variable in PREFIX_VARIABLES:
        for path in environment.get(variable, "").split(os.pathsep):
            if Path(path).is_absolute():
                yield Prefix(path, variable)
    for path in environment.get(SOURCES_VARIABLE, "").split(os.pathsep) if ros == 1 else ():
        folder = Path(path)
        if folder.is_absolute():
            # The `share` of a prefix is one of them.
            is_share = folder.name == SHARE
            top = folder.parent if is_share else folder
            yield Prefix(str(top), SOURCES_VARIABLE, is_sources=not is_share)


def _of_system(
    environment: Mapping[str, str], ros: RosVersion, distro: str | None
) -> Iterator[Prefix]:
    """Yield one installed ROS; none where a variable names one: two are never sourced."""
    if any(f"{INSTALLED}{os.sep}" in environment.get(name, "") for name in PREFIX_VARIABLES):
        return
    folders = sorted(_folders_in(INSTALLED), reverse=True)
    of_this = [folder for folder in folders if _ros_of(Prefix(str(INSTALLED / folder), "")) == ros]
    first = next((name for name in (environment.get("ROS_DISTRO"), distro) if name in of_this), "")
    for name in (first, *of_this)[not first :][:1]:
        yield Prefix(str(INSTALLED / name), str(INSTALLED))


def _parts(prefix: Prefix) -> Iterator[Prefix]:
    """Yield a prefix, or those below it where each package has one of its own.

    Before a `devel` space come the folders of its sources, to whose modules it leads.
    """
    folder = Path(prefix.path)
    if prefix.is_sources:
        if folder.is_dir():
            yield prefix
        return
    if is_prefix(folder) or (prefix.found_in == _SETTING and (folder / SHARE).is_dir()):
        for sources in _catkin_sources(prefix):
            yield replace(prefix, path=str(sources), is_sources=True)
        yield prefix
        return
    for name in sorted(_folders_in(folder)):
        if is_prefix(folder / name):
            yield Prefix(str(folder / name), prefix.found_in, prefix.within)


def _ros_of(prefix: Prefix) -> RosVersion | None:
    """Return of which ROS a prefix is; `None` where nothing says it."""
    folder = Path(prefix.path)
    if (folder / CATKIN_MARK).exists() or (prefix.is_sources and not prefix.fills_in):
        return 1
    return 2 if (folder / AMENT_INDEX).is_dir() else None


def installed_packages(prefixes: Iterable[Prefix]) -> dict[str, Path]:
    """Return the packages of prefixes with the folders of their files, sorted by their names.

    One in sources that is built for the other ROS counts where no other has its name.
    """
    paths: dict[str, Path] = {}
    of_other_ros: dict[str, Path] = {}
    for prefix in prefixes:
        for name, folder in _packages_of(prefix):
            is_other = prefix.is_sources and is_of_other_ros(folder, prefix.ros)
            if len(paths) < _MOST_PACKAGES:
                (of_other_ros if is_other else paths).setdefault(name, folder)
    return dict(sorted({**of_other_ros, **paths}.items()))


def _packages_of(prefix: Prefix) -> Iterator[tuple[str, Path]]:
    if prefix.is_sources:
        yield from _in_sources(prefix)
        return
    share = Path(prefix.path, SHARE)
    listed = {
        name
        for index in (f"{AMENT_INDEX}/packages", COLCON_PACKAGES)
        for name in _names_in(Path(prefix.path, index))
    }
    if not listed:
        listed = {name for name in _folders_in(share) if (share / name / PACKAGE_FILE).is_file()}
    for name in sorted(listed):
        if _PACKAGE.fullmatch(name) and _is_within(share / name, prefix):
            yield name, share / name


def _in_sources(prefix: Prefix) -> Iterator[tuple[str, Path]]:
    if _is_within(Path(prefix.path), prefix):
        search = packages_of_sibling if prefix.fills_in else packages_below
        for folder in search(Path(prefix.path)):
            yield name_of(folder), folder


def _catkin_sources(prefix: Prefix) -> list[Path]:
    """Return the folders of sources of a `devel` space; none for an `install` space."""
    text = head_of(Path(prefix.path, CATKIN_MARK), _MOST_BYTES)
    return [Path(folder) for folder in text.strip().split(";") if Path(folder).is_absolute()]


def _is_within(path: Path, prefix: Prefix) -> bool:
    if not prefix.within:
        return True
    within = os.path.realpath(prefix.within)
    return os.path.commonpath((os.path.realpath(path), within)) == within


def readable_of(prefixes: Iterable[Prefix]) -> tuple[Path, ...]:
    """Return the folders in which the files of prefixes lie, and those to which they link."""
    readable: dict[Path, None] = {}
    for prefix in prefixes:
        folders = prefix_folders(Path(prefix.path))
        readable.update((folder, None) for folder in folders if _is_within(folder, prefix))
    return tuple(readable)


def python_folders(prefixes: Iterable[Prefix]) -> tuple[Path, ...]:
    """Return the folders of prefixes that hold Python modules, but for what Python has on its path.

    Of one prefix those of this Python's version come first. A package that is installed as links
    into its sources has the folder of these.
    """
    on_path = {os.path.realpath(path) for path in sys.path}
    table: dict[Path, None] = {}
    for prefix in prefixes:
        for folder in _modules_of(prefix):
            if os.path.realpath(folder) not in on_path and _is_within(folder, prefix):
                table.setdefault(folder)
    return tuple(table)


def _modules_of(prefix: Prefix) -> Iterator[Path]:
    if prefix.is_sources:
        for name, package in _in_sources(prefix):
            if (package / "setup.py").is_file() and (package / SOURCES).is_dir():
                yield package / SOURCES
            elif prefix.fills_in and (package / name / "__init__.py").is_file():
                yield package
        return
    for lib in ("lib", "local/lib"):
        top = Path(prefix.path, lib)
        versions = [name for name in _folders_in(top) if _PYTHON.fullmatch(name)]
        for version in sorted(versions, key=_strangeness):
            for name in ("site-packages", "dist-packages"):
                folder = top / version / name
                if folder.is_dir():
                    yield folder
                    yield from _linked_from(folder)


def _strangeness(version: str) -> tuple[bool, bool, int]:
    """Return a key that sorts folders of Python: this version's, that of none, newer ones."""
    matched = _PYTHON.fullmatch(version)
    minor = int(matched[1]) if matched is not None and matched[1] else 0
    return minor != sys.version_info.minor, minor != 0, -minor


def _linked_from(folder: Path) -> Iterator[Path]:
    """Yield the folders that `*.egg-link` files name: packages that are installed as links."""
    for name in sorted(_names_in(folder)):
        if not name.endswith(".egg-link"):
            continue
        first = head_of(folder / name, _MOST_BYTES).split("\n")[0].strip()
        if Path(first).is_absolute() and Path(first).is_dir():
            yield Path(first)


def with_interfaces(packages: Mapping[str, Path]) -> dict[str, Path]:
    """Return those of installed packages that have messages, services or actions."""
    return {
        name: folder
        for name, folder in packages.items()
        if any((folder / kind).is_dir() for kind in _KINDS)
    }


def _names_in(folder: Path) -> list[str]:
    """Return the names of the files in a folder, hidden ones left out."""
    try:
        with os.scandir(folder) as entries:
            names = (entry.name for entry in entries if _is_file(entry))
            return [name for name in names if not name.startswith(".")]
    except OSError:
        return []


def _folders_in(folder: Path) -> list[str]:
    try:
        with os.scandir(folder) as entries:
            return [
                entry.name for entry in entries if not entry.name.startswith(".") and _is_dir(entry)
            ]
    except OSError:
        return []


def _is_file(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_file()
    except OSError:  # links in a circle
        return False


def _is_dir(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:
        return False
