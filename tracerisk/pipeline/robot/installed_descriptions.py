"""The installed packages in which the robot of a controller may be described."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

from tracerisk.pipeline.workspace.package_folders import declared_needs
from tracerisk.pipeline.workspace.prefixes import Prefix, installed_packages
from tracerisk.pipeline.workspace.workspace import Workspace, named_packages, packages_in
from tracerisk.twin.workspace.srdf_pairing import noted_package

_FOLDERS = ("urdf", "robots", "robot", "xacro", "srdf", "description")
_ENDINGS = (".srdf", ".urdf", ".xacro")
_OF_MOVEIT = "_moveit_config"
_BUILDER = b"MoveItConfigsBuilder"
_MOST_READ = 200
_NAMING = re.compile(
    r"\$\((?:find|find-pkg-share|dirname) |package://|\broslaunch |\brosrun |\bros2 "
)


def installed_descriptions(
    root: Path, workspace: Workspace, strings: Iterable[str], source: bytes
) -> dict[str, Path]:
    """Return the installed packages with robots that a controller names, and those behind them.

    It names them in its `strings`, its launch files or its manifest, and a package
    `<name>_moveit_config` by the name alone, as MoveItConfigsBuilder does. Those that only lie
    beside its project it must name in its strings, and not in prose; there a name alone, which
    may be a group's, counts only if its `source` has that builder. Behind them are the packages on
    which they depend, as far as these describe robots. With one that lies beside the project comes
    the configuration of MoveIt that lies next to it and is for it.
    """
    installed = workspace.installed
    if not installed:
        return {}
    strings = tuple(strings)
    from_prefixes = installed_packages(
        prefix for prefix in workspace.prefixes if not prefix.fills_in
    )
    named = named_packages(root, from_prefixes, strings) & installed.keys()
    named |= packages_in(filter(_may_name, strings)) & installed.keys()
    may_build = installed if _BUILDER in source else from_prefixes
    of_moveit = (
        {f"{string}{_OF_MOVEIT}" for string in strings} & may_build.keys() & installed.keys()
    )
    waiting = sorted(named | of_moveit)
    seen = set(waiting)
    descriptions: dict[str, Path] = {}
    for count, name in enumerate(waiting):
        folder = installed[name]
        describes = _describes(folder)
        if describes:
            descriptions[name] = folder
        if count >= _MOST_READ or not (describes or name in named):
            continue
        noted = noted_package(folder)
        for need in (*declared_needs(folder), *([noted] if noted else [])):
            if need in installed and need not in seen:
                seen.add(need)
                waiting.append(need)
    for name in sorted(installed.keys() - from_prefixes.keys() - descriptions.keys()):
        folder = installed[name]
        if name.endswith(_OF_MOVEIT) and any(
            need in descriptions and descriptions[need].parent == folder.parent
            for need in (*declared_needs(folder), noted_package(folder))
        ):
            descriptions[name] = folder
    return descriptions


def installed_in(files: Iterable[Path], prefixes: Iterable[Prefix]) -> str:
    """Return in words in which prefixes files of a robot are; empty for none."""
    files = tuple(files)
    places = [
        f"{prefix.path} ({prefix.found_in})"
        for prefix in prefixes
        if any(file.is_relative_to(Path(prefix.path).resolve()) for file in files)
    ]
    return f"; installed in {', '.join(places)}" if places else ""


def _may_name(text: str) -> bool:
    """Return whether a text may name a package: a word, a path, a command, and no sentence."""
    return len(text.split()) == 1 or bool(_NAMING.search(text))


def _describes(folder: Path) -> bool:
    """Return whether a package has a folder for robots, or a file that describes one."""
    if any((folder / name).is_dir() for name in _FOLDERS):
        return True
    return any(name.endswith(_ENDINGS) for name in _names_in(folder / "config"))


def _names_in(folder: Path) -> list[str]:
    try:
        return os.listdir(folder)  # noqa: PTH208 - of hundreds of packages
    except OSError:
        return []
