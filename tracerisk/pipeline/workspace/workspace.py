"""The ROS workspace around a controller: its packages, importable as if they were built."""

from __future__ import annotations

import itertools
import os
import re
import time
from collections import deque
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path

from tracerisk.records import dataclass
from tracerisk.text.patterns import pattern

PACKAGE_FILE = "package.xml"
_INTERFACES = ("msg", "srv", "action")
_ENVIRONMENT = "pyvenv.cfg"  # lies at the top of an environment of Python
_IGNORED_MARKS = ("COLCON_IGNORE", "CATKIN_IGNORE", "AMENT_IGNORE")
NOT_SEARCHED = frozenset({"build", "devel", "install", "log", "node_modules", "__pycache__"})
MOST_ENTRIES = 50_000
"""How many files and folders a search for packages looks at."""
LONGEST_SEARCH_S = 10.0
"""How long a search for packages takes: folders may lie on a slow disk [s]."""
TESTS = frozenset({"test", "tests"})
_UPWARDS = 4
_REPOSITORY = ".git"
_SOURCES = "src"  # where a workspace keeps its packages
_TOP_FILES = ("readme", "licence", "license")
_TOP_MARKS = frozenset(
    {".catkin_workspace", ".catkin_tools", ".github", ".gitignore", ".gitlab-ci.yml", ".gitmodules",
     ".rosinstall", ".travis.yml", "colcon.meta"}
)  # fmt: skip
_MOST_MODULES = 300
_IMPORT = pattern(r"^[ \t]*(?:from|import)[ \t]+(\w+)", re.MULTILINE)
_MOST_FOLDERS = 5000
_BESIDE = 2
_NEED = pattern(r"<(?:\w+_)?depend\b[^>]*>\s*([\w.-]+)\s*<")
_WORD = pattern(r"[\w.-]+")
_LAUNCH_ENDINGS = (".launch", ".py", ".xml", ".yaml")
_NAME = pattern(r"<name>\s*([\w.-]+)\s*</name>")


@dataclass(frozen=True, slots=True)
class Workspace:
    """The packages that can be seen from a controller: each name and the folder it stands in."""

    packages: Mapping[str, Path]

    @property
    def interfaces(self) -> dict[str, Path]:
        """The packages that hold messages, services or actions of their own."""
        return {
            name: folder
            for name, folder in self.packages.items()
            if any(any((folder / kind).rglob(f"*.{kind}")) for kind in _INTERFACES)
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
        found: dict[str, Path] = {}
        folders = [*self.packages.items(), *((folder.name, folder) for folder in self.import_paths)]
        for name, folder in folders:
            for each in sorted(folder.iterdir()):
                is_python = (each / "__init__.py").is_file() and each.name not in TESTS
                if is_python or (each.name == name and any(each.glob("*.py"))):
                    found.setdefault(each.name, folder)
        return found

    def folder_of_module(self, name: str, root: Path) -> Path | None:
        """Return the folder of a module that stands off the import path, `None` for none.

        Some packages install modules where only their own set-up finds them. What stands below
        `root` goes before the rest of the workspace; of several the one whose path sorts first.
        """
        for folders in ([root.resolve()], list(self.packages.values())):
            found = [each for folder in folders for each in _modules_named(name, folder)]
            if found:
                return min(found, key=lambda each: (len(each.parts), each))
        return None


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
                entries = sorted(listed, key=lambda each: each.name)
        except OSError:
            continue
        files = [each.name for each in entries if _is_file(each)]
        if not environments and _ENVIRONMENT in files:
            continue
        yield folder, files
        waiting += [
            each.path
            for each in reversed(entries)
            if each.is_dir(follow_symlinks=False)
            and not each.name.startswith(".")
            and each.name not in left_out
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


def find_workspace(root: Path) -> Workspace:
    """Return the packages below a controller's root and, where that is one itself, around it.

    A root that is no package has those around it where it lies in the `src` of a workspace, or
    beside that in the same repository.

    Looked for upwards within the repository; without one, at most four folders up. Then it is
    the folder `src` of a workspace, or the nearest folder with what lies at the top of a
    repository (a readme, a licence, ...). Where there is neither, what lies beside a package is
    none of its own but for the packages that it depends on. So do those of the other repositories
    in the same `src`.
    Packages at any depth are found. The search begins at `root` and goes on upwards, so that what
    a very large project has in other places is left out first.
    Where two packages have one name, the one that contains `root` or is nearest to it wins.
    """
    top = project_top(root)
    packages: dict[str, Path] = {}
    for folder in _packages_below(top, first=root.resolve()):
        known = packages.setdefault(_name_of(folder), folder)
        if _apart(folder, root.resolve()) < _apart(known, root.resolve()):
            packages[_name_of(folder)] = folder
    if (root / PACKAGE_FILE).is_file():
        in_sources = any(each.name == _SOURCES for each in top.parents[:_BESIDE])
        if in_sources or (top == root.resolve() and not (top / _REPOSITORY).exists()):
            packages = {**_needed_beside(root.resolve()), **packages}
        packages[_name_of(root.resolve())] = root.resolve()
    return Workspace(dict(sorted(packages.items())))


def _apart(one: Path, other: Path) -> int:
    """Return how many folders lie between two folders."""
    shared = len(os.path.commonpath((one, other)).rstrip("/").split("/"))
    return len(one.parts) + len(other.parts) - 2 * shared


def named_packages(
    root: Path, packages: Mapping[str, Path], strings: Iterable[str]
) -> frozenset[str]:
    """Return the packages that a controller's `strings`, launch files or manifest name.

    The package of `root` is one of them.
    """
    words = {word for string in strings for word in _WORD.findall(string)}
    for file in itertools.islice(sorted(root.rglob("*launch*")), _MOST_MODULES):
        if file.is_file() and file.suffix in _LAUNCH_ENDINGS:
            words.update(_WORD.findall(file.read_text(encoding="utf-8", errors="replace")))
    if (root / PACKAGE_FILE).is_file():
        words.update((*declared_needs(root), _name_of(root)))
    return frozenset(words & packages.keys())


def declared_needs(root: Path) -> tuple[str, ...]:
    """Return the packages on which the manifest in `root` says that its package depends."""
    try:
        text = (root / PACKAGE_FILE).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ()
    return tuple(_NEED.findall(text))


def imported_names(source: str) -> set[str]:
    """Return the first part of each module that the lines of a source import."""
    return set(_IMPORT.findall(source))


def project_top(root: Path) -> Path:
    """Return the folder whose files belong to one project with the controller in `root`."""
    root = root.resolve()
    if (root / _REPOSITORY).exists():
        return root
    above = list(
        itertools.takewhile(lambda folder: folder not in (Path.home(), Path("/")), root.parents)
    )
    height = next(
        (number for number, folder in enumerate(above) if (folder / _REPOSITORY).exists()), None
    )
    # Within a repository nothing is too far away.
    upwards = above[:_UPWARDS] if height is None else above[: height + 1]
    if not (root / PACKAGE_FILE).is_file():
        # A script in no package may lie among those of a workspace all the same.
        sources = next((each for each in upwards if each.name == _SOURCES), None)
        if sources is None:
            # Or beside its folder `src`.
            top = next((each for each in upwards if _is_marked(each)), root)
            return top if any(_packages_below(top / _SOURCES)) else root
        if not any(_packages_below(sources)):
            return root
        return sources.parent if _is_marked(sources.parent) else sources
    if height is not None:
        return above[height]
    for folder in upwards:
        if _is_marked(folder):
            return folder
        if folder.name == _SOURCES:
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


def _needed_beside(root: Path) -> dict[str, Path]:
    """Return the packages beside `root` that it needs, and those that these need."""
    beside: dict[str, Path] = {}
    for folder in root.parents[:_BESIDE]:
        if folder not in (Path.home(), Path("/")):
            for package in _packages_below(folder, deepest=_BESIDE):
                beside.setdefault(_name_of(package), package)
    found: dict[str, Path] = {}
    waiting = [root]
    while waiting:
        for name in _needs_of(waiting.pop()):
            if name in beside and name not in found and beside[name] != root:
                found[name] = beside[name]
                waiting.append(beside[name])
    return found


def _needs_of(folder: Path) -> list[str]:
    """Return what a package says it needs, and what its modules import without saying so."""
    modules = itertools.islice(sorted(folder.rglob("*.py")), _MOST_MODULES)
    imported = {
        name
        for module in modules
        if module.is_file()
        for name in imported_names(module.read_text(encoding="utf-8", errors="replace"))
    }
    return [*declared_needs(folder), *sorted(imported)]


def _packages_below(
    top: Path, deepest: int | None = None, first: Path | None = None
) -> Iterator[Path]:
    """Yield the folders with a `package.xml`, none inside another.

    Those in and beside `first`, a folder below `top`, come before others, then the nearer to the
    top. The search ends after `MOST_ENTRIES` entries or `LONGEST_SEARCH_S`.
    """
    waiting = deque([(top, 0)])
    if first is not None and first != top and first.is_relative_to(top):
        depth = len(first.parts) - len(top.parts)
        around = [first, *first.parents[: depth - 1]]
        waiting.extendleft((folder, len(folder.parts) - len(top.parts)) for folder in around[::-1])
    seen: set[Path] = set()
    entries_left, ends_at = MOST_ENTRIES, time.monotonic() + LONGEST_SEARCH_S
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
        if names.intersection(_IGNORED_MARKS) or _ENVIRONMENT in names:
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


def _name_of(folder: Path) -> str:
    try:
        text = (folder / PACKAGE_FILE).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return folder.name
    found = _NAME.search(text)
    return found[1] if found else folder.name
