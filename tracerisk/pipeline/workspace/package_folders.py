"""Folders of ROS packages in sources: those that have a `package.xml`, and their names."""

from __future__ import annotations

import itertools
import os
import stat
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path

from tracerisk.common.text.patterns import pattern

PACKAGE_FILE = "package.xml"
NOT_SEARCHED = frozenset({"build", "devel", "install", "log", "node_modules", "__pycache__"})
ENVIRONMENT = "pyvenv.cfg"
"""The file at the top of an environment of Python."""
MOST_ENTRIES = 50_000
"""How many files and folders a search for packages looks at."""
LONGEST_SEARCH_S = 10.0
"""How long a search for packages takes: folders may lie on a slow disk [s]."""

_IGNORED_MARKS = ("COLCON_IGNORE", "CATKIN_IGNORE", "AMENT_IGNORE")
_MOST_BYTES = 256 * 1024
_NAME = pattern(r"<name>\s*([\w.-]+)\s*</name>")
_NEED = pattern(r"<(?:\w+_)?depend\b[^>]*>\s*([\w.-]+)\s*<")


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
    found = _NAME.search(manifest_text(folder))
    return found[1] if found else folder.name


def declared_needs(folder: Path) -> tuple[str, ...]:
    """Return the packages on which the manifest in a folder says that its package depends."""
    return tuple(_NEED.findall(manifest_text(folder)))


def manifest_text(folder: Path) -> str:
    """Return the first 256 kB of the `package.xml` in a folder; empty where it is not a file."""
    return head_of(folder / PACKAGE_FILE, _MOST_BYTES)


def head_of(path: Path, most: int) -> str:
    """Return the first bytes of a file, at most `most`, as a text; empty where it is not a file."""
    try:
        # A pipe would keep who opens it waiting.
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(descriptor, "rb") as stream:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                return ""
            return stream.read(most).decode("utf-8", errors="replace")
    except OSError:
        return ""
