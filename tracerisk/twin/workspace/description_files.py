"""The files that may describe a robot: SRDF, URDF and xacro below the folders of a workspace."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes

_MOST_FILES = 400
_MOST_FOLDERS = 4000
_DEEPEST = 8
_MOST_BYTES = 4 * 1024 * 1024
_NOT_SEARCHED = frozenset(
    {"build", "devel", "install", "log", "node_modules", "__pycache__", "venv"}
)
_ENDINGS = (".srdf", ".urdf", ".xacro")
_ROBOT_NAME = re.compile(r"<robot\b[^>]*\bname\s*=\s*[\"']([^\"']+)[\"']", re.DOTALL)
# A URDF has neither; an author's command line may expand a file of either name.
_MACRO_SIGNS = (b"<xacro:", b"${")
_INCLUDE = re.compile(rb"<(?:xacro:)?include\b[^>]*\bfilename\s*=\s*[\"']([^\"']+)[\"']")


@dataclass(frozen=True, slots=True)
class DescriptionFile:
    """A file that may describe a robot."""

    path: Path
    """The file on disk."""
    shown: str
    """The path below the workspace, for messages."""
    text: bytes
    """The content, with macros not yet expanded."""

    @property
    def words(self) -> frozenset[str]:
        """The names in the text, as far as they can be seen before macros are expanded."""
        names = re.findall(rb"name\s*=\s*[\"']([^\"'$]+)[\"']", self.text)
        return frozenset(name.decode(errors="replace") for name in names)

    @property
    def robot_name(self) -> str:
        """The name of the robot as it is written, which macros may make; empty for none."""
        matched = _ROBOT_NAME.search(self.text.decode(errors="replace"))
        return matched[1] if matched else ""

    @property
    def stem(self) -> str:
        """The file's name up to its first dot."""
        return self.path.name.split(".")[0]

    @property
    def is_srdf(self) -> bool:
        """Whether it holds groups and states, and no joints of its own."""
        return ".srdf" in self.path.name

    @property
    def is_robot(self) -> bool:
        """Whether it holds a `<robot>`, or a part of one."""
        return b"<robot" in self.text

    @property
    def is_macro(self) -> bool:
        """Whether macros must be expanded before it can be read."""
        named = self.path.name.endswith(".xacro")
        return named or any(sign in self.text for sign in _MACRO_SIGNS)

    @property
    def included(self) -> frozenset[str]:
        """The names of the files that it includes."""
        return frozenset(
            name.rpartition(b"/")[2].decode(errors="replace")
            for name in _INCLUDE.findall(self.text)
        )


def description_files(roots: tuple[Path, ...]) -> list[DescriptionFile]:
    """Return the files below the roots that may describe a robot, nearer ones first.

    What cannot be read, or is larger than 4 MB, is left out; of a great many files the rest is.
    """
    files = (read_description(path, roots) for path in _found(roots))
    return [file for file in files if file is not None]


def read_description(path: Path, roots: tuple[Path, ...]) -> DescriptionFile | None:
    """Return one file, `None` where it cannot be read or is larger than 4 MB."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            return None
        text = file_bytes(path)
    except OSError:
        return None
    top = next((root for root in roots if path.is_relative_to(root.resolve())), None)
    shown = path.name if top is None else path.relative_to(top.resolve()).as_posix()
    return DescriptionFile(path, shown, text)


def distance(one: Path, other: Path) -> int:
    """Return how many folders lie between two files."""
    shared = 0
    for left, right in zip(one.parts, other.parts, strict=False):
        if left != right:
            break
        shared += 1
    return len(one.parts) + len(other.parts) - 2 * shared


def _found(roots: tuple[Path, ...]) -> Iterator[Path]:
    """Yield the files that may describe a robot, nearer ones first, each folder's sorted."""
    waiting = [(root.resolve(), 0) for root in roots]
    seen: set[Path] = set()
    count = 0
    while waiting and len(seen) < _MOST_FOLDERS:
        folder, depth = waiting.pop(0)
        if folder in seen:
            continue
        seen.add(folder)
        try:
            with os.scandir(folder) as listed:
                entries = sorted(listed, key=lambda entry: entry.name)
        except OSError:
            continue
        for entry in entries:
            name = entry.name
            if entry.is_dir(follow_symlinks=False):
                if depth < _DEEPEST and name not in _NOT_SEARCHED and not name.startswith("."):
                    waiting.append((Path(entry.path), depth + 1))
            elif name.endswith(_ENDINGS) and entry.is_file():
                count += 1
                if count > _MOST_FILES:
                    return
                yield Path(entry.path)
