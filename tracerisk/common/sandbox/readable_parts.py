"""Which parts of the machine a sandboxed process may read."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator
from functools import lru_cache
from pathlib import Path

from tracerisk.common.limits import is_secret

_SYSTEM = (
    *("/bin", "/lib", "/lib32", "/lib64", "/libx32", "/sbin", "/usr", "/opt/ros", "/nix/store"),
    *("/etc/alternatives", "/etc/fonts", "/etc/group", "/etc/hosts", "/etc/ld.so.cache"),
    *(
        "/etc/ld.so.conf",
        "/etc/ld.so.conf.d",
        "/etc/localtime",
        "/etc/locale.alias",
        "/etc/magic",
        "/etc/mime.types",
    ),
    *("/etc/nsswitch.conf", "/etc/os-release", "/etc/passwd", "/etc/protocols", "/etc/services"),
    *("/etc/timezone", "/dev/full", "/dev/random", "/dev/urandom", "/dev/zero"),
    *("/proc/cpuinfo", "/proc/filesystems", "/proc/meminfo", "/proc/stat", "/proc/version"),
    *("/sys/devices/system/cpu", "/sys/devices/system/node"),
)


_SOURCE_ENDINGS = (".py", ".yaml", ".yml", ".json", ".toml", ".urdf", ".xacro", ".srdf", ".xml")


_DEEPEST = 100  # levels of folders that are looked through for keys; below them nothing is read


_INSTALLED = ("site-packages", "dist-packages")


def readable_parts(installed: Iterable[Path], given: Iterable[Path]) -> dict[str, bool]:
    """Return what is readable of the system, of what is installed and of places that are given.

    For each path it says whether it may be read with all that is below it, or only listed.
    """
    parts = dict.fromkeys(_SYSTEM, True)
    for places, is_installed in ((installed, True), (given, False)):
        # What lies below a place that is read already needs no look.
        for place in sorted(_resolved(places), key=lambda path: path.count(os.sep)):
            if place in parts or any(map(parts.get, _parents(place))):
                continue
            for path, is_whole in _within(Path(place), is_installed=is_installed):
                parts[path] = is_whole or parts.get(path, False)
    return parts


def _resolved(places: Iterable[Path]) -> Iterator[str]:
    for place in dict.fromkeys(places):
        with contextlib.suppress(OSError, RuntimeError):
            yield str(place.resolve())


def _parents(path: str) -> Iterator[str]:
    while path != os.sep:
        path = path.rpartition(os.sep)[0] or os.sep
        yield path


def _within(path: Path, *, is_installed: bool) -> list[tuple[str, bool]]:
    """Return what of a place is readable: itself, or its parts where it holds what is not.

    With each path stands whether it may be read, or only listed. What is installed is looked
    through at its top alone.
    """
    try:
        if not path.is_dir():
            return [(str(path), True)]
        homes = _homes(os.environ.get("HOME"))
        if any(path in home.parents for home in homes):
            return []
        if path in homes:
            # The folder of everything is not a folder of sources, though sources may lie in it.
            inside = (item for item in sorted(path.iterdir()) if not item.is_symlink())
            parts = [item for item in inside if item.is_file() and item.suffix in _SOURCE_ENDINGS]
            return [(str(path), False), *((str(part), True) for part in parts)]
        return _parts_of(str(path), 1, is_installed=is_installed)
    except (OSError, RuntimeError):
        return []


def _parts_of(folder: str, level: int, *, is_installed: bool) -> list[tuple[str, bool]]:
    """Return a folder where nothing in it is secret; else its parts. `level` is how deep it lies.

    A link that stands among them is no part: what it leads to may lie anywhere.
    """
    parts: list[tuple[str, bool]] = []
    is_whole = True
    with os.scandir(folder) as entries:
        ordered = sorted(entries, key=lambda entry: entry.name)
    for entry in ordered:
        if is_secret(entry.name):
            is_whole = False
        elif entry.is_symlink():
            continue
        elif not entry.is_dir() or is_installed:
            parts.append((entry.path, True))
        else:
            inner = _inner_parts(entry, level + 1)
            is_whole = is_whole and inner == [(entry.path, True)]
            parts += inner
    return [(folder, True)] if is_whole else [(folder, False), *parts]


def _inner_parts(folder: os.DirEntry[str], level: int) -> list[tuple[str, bool]]:
    try:
        # The certificates among what is installed are those of authorities.
        is_installed = folder.name in _INSTALLED
        return _parts_of(folder.path, level, is_installed=is_installed) if level <= _DEEPEST else []
    except OSError:
        return []  # who may not list it may not read it


@lru_cache(maxsize=2)
def _homes(_: str | None) -> tuple[Path, ...]:
    """Return the home folders of this user: what HOME says, and what the system knows."""
    return tuple(Path(name).expanduser().resolve() for name in ("~", _home_on_record()))


def _home_on_record() -> str:
    """Return the home folder of this user that the system knows, whatever HOME says."""
    import pwd

    try:
        return pwd.getpwuid(os.getuid()).pw_dir
    except KeyError:
        return "/"
