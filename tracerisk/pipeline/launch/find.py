"""Find the launch files of a workspace that speak of a program, or include one that does."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Literal

from tracerisk.common.text.bounded import file_text
from tracerisk.pipeline.launch.program import Program
from tracerisk.pipeline.workspace.workspace import TESTS, Workspace, searched

_MOST_FOLDERS = 5000
_MOST_FILES = 1000
_MOST_BYTES = 1024 * 1024
_NAMED = re.compile(r".*([._]launch\.(py|xml|yaml|yml)|\.launch)|launch\.(py|xml|yaml|yml)")
_IN_FOLDER = re.compile(r".*\.(py|xml|yaml|yml)")
_ROS2_XML = re.compile(r"\bexec\s*=|find-pkg-share|\$\(var\s|push[-_]ros[-_]namespace")
_ROS1_XML = re.compile(r"<node\b[^>]*\btype\s*=|\$\(arg\s|\$\(find\s|<rosparam\b|<test\b")


@dataclass(frozen=True, slots=True)
class LaunchFile:
    """A launch file."""

    path: Path
    """The file."""
    ros: Literal[1, 2]
    """Of which ROS it is."""
    is_direct: bool
    """Whether it speaks of the program itself."""
    is_test: bool = False
    """Whether it is of a test."""
    arguments: tuple[tuple[str, str], ...] = ()
    """The arguments that a command of a readme gives it."""
    said_in: str = ""
    """Where that command stands, from the controller's root; empty for none."""

    @property
    def given(self) -> str:
        """Its arguments in words: `ur_type:=ur5e of README.md:12`; empty for none."""
        listed = " ".join(f"{name}:={value}" for name, value in self.arguments)
        return f"{listed} of {self.said_in}" if listed else ""


def find_launch_files(
    program: Program, root: Path, workspace: Workspace, ros: Literal[1, 2]
) -> tuple[LaunchFile, ...]:
    """Return the launch files of one ROS that may start a program.

    Those that speak of it come first, then those that include one of these; within each, those of
    tests last, else sorted by their paths.
    """
    tops = _tops([root.resolve(), *workspace.packages.values()])
    texts = launch_texts(root, workspace, ros)
    direct = [path for path, text in texts.items() if program.is_named_in(text)]
    rest: list[Path] = []
    reached = {path.name for path in direct}
    while True:
        more = [
            path
            for path, text in texts.items()
            if path not in direct and path not in rest and _names_any(text, reached)
        ]
        if not more:
            break
        rest += more
        reached = {path.name for path in more}
    launch_files = [LaunchFile(path, ros, True, is_test(path, *tops)) for path in direct]
    launch_files += [LaunchFile(path, ros, False, is_test(path, *tops)) for path in rest]
    return tuple(
        sorted(
            launch_files,
            key=lambda launch_file: (
                not launch_file.is_direct,
                launch_file.is_test,
                launch_file.path,
            ),
        )
    )


def launch_texts(root: Path, workspace: Workspace, ros: Literal[1, 2]) -> dict[Path, str]:
    """Return the launch files of one ROS in a workspace, each with its text."""
    tops = _tops([root.resolve(), *workspace.packages.values()])
    texts = {path: _text(path) for path in _launch_files(tops)}
    return {path: text for path, text in texts.items() if text and ros_of(path, text) == ros}


def ros_of(path: Path, text: str) -> Literal[1, 2] | None:
    """Return of which ROS a launch file is, None where it is none."""
    if path.suffix == ".py":
        has_function = "generate_launch_description" in text or "generate_test_descr" in text
        return 2 if has_function else None
    if path.suffix in (".yaml", ".yml"):
        return 2 if re.search(r"^\s*launch\s*:", text, re.MULTILINE) else None
    if "<launch" not in text:
        return None
    if _ROS2_XML.search(text):
        return 2
    return 1 if _ROS1_XML.search(text) or path.suffix == ".launch" else 2


def is_test(path: Path, *tops: Path) -> bool:
    """Return whether a file is one of a test, wherever the workspace itself stands."""
    within = next((path.relative_to(top) for top in tops if path.is_relative_to(top)), path)
    return bool(TESTS.intersection(within.parts)) or path.name.startswith("test_")


def _names_any(text: str, names: set[str]) -> bool:
    return any(re.search(rf"(?<![\w.-]){re.escape(name)}(?![\w-])", text) for name in names)


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > _MOST_BYTES:
            return ""
        return file_text(path, errors="replace")
    except OSError:
        return ""


def _launch_files(tops: Sequence[Path]) -> list[Path]:
    launch_files: dict[Path, None] = {}
    for folder in tops:
        for path in _below(folder):
            launch_files.setdefault(path)
            if len(launch_files) >= _MOST_FILES:
                return list(launch_files)
    return list(launch_files)


def _tops(folders: Sequence[Path]) -> list[Path]:
    """Return the folders that are not within another."""
    return sorted(
        {
            folder
            for folder in folders
            if not any(folder != other and folder.is_relative_to(other) for other in folders)
        }
    )


def _below(top: Path) -> Iterator[Path]:
    for folder, files in islice(searched(top), _MOST_FOLDERS):
        is_launch_folder = "launch" in Path(folder).relative_to(top.parent).parts
        for name in files:
            if _NAMED.fullmatch(name) or (is_launch_folder and _IN_FOLDER.fullmatch(name)):
                yield Path(folder, name)
