"""Under which package and names launch files start a script."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tracerisk.pipeline.launch_files.records import StartedNode
from tracerisk.pipeline.workspace.console_scripts import console_scripts, read_or_nothing
from tracerisk.pipeline.workspace.controller import from_root
from tracerisk.pipeline.workspace.workspace import Workspace

_RENAMED = re.compile(
    r"(?P<file>[\w./${}-]+)\s+DESTINATION\s+\S+\s+RENAME\s+(?P<name>[\w.-]+)", re.IGNORECASE
)
_RUNNERS = frozenset({"run", "rosrun"})


@dataclass(frozen=True, slots=True)
class Program:
    """A script as launch files call it."""

    script: Path
    """The path of the script, links resolved."""
    package: str
    """The name of its package."""
    names: frozenset[str]
    """The names of its executable: file, entry points and installed names."""

    def started_as(self, node: StartedNode) -> StartedNode | None:
        """Return a node with the arguments of the script itself, None where it is another."""
        if not node.command:
            is_same = node.package == self.package and Path(node.executable).name in self.names
            return node if is_same else None
        return self._in_command(node)

    def _in_command(self, node: StartedNode) -> StartedNode | None:
        words = node.command
        for at, word in enumerate(words):
            rest = words[at + 1 :]
            if Path(word).name == self.script.name and self._is_script(word):
                return replace(node, arguments=rest)
            is_run = Path(word).name in _RUNNERS and rest[:1] == (self.package,)
            if is_run and len(rest) > 1 and rest[1] in self.names:
                return replace(node, arguments=rest[2:])
        return None

    def _is_script(self, word: str) -> bool:
        path = Path(word)
        return path == Path(path.name) or os.path.realpath(path) == str(self.script)

    def is_named_in(self, text: str) -> bool:
        """Return whether a text names the program: with its package, or by its file's name."""
        file = self.script.name
        names = self.names if _is_word(self.package, text) else {file} if "." in file else ()
        return any(_is_word(name, text) for name in names)


def _is_word(name: str, text: str) -> bool:
    return re.search(rf"(?<![\w.-]){re.escape(name)}(?![\w-])", text) is not None


def program_of(script: Path, root: Path, workspace: Workspace) -> Program:
    """Return how launch files call a script.

    That is its file's name, what `setup.py`, `setup.cfg` or `pyproject.toml` call its function,
    the name under which `CMakeLists.txt` installs it and, if nothing else is called so, the
    file's name without `.py`.
    """
    script = script.resolve()
    holders = [
        (len(folder.parts), name, folder)
        for name, folder in workspace.packages.items()
        if script.is_relative_to(folder)
    ]
    _, package, folder = max(holders, default=(0, root.resolve().name, root.resolve()))
    names = {script.name}
    claimed: set[str] = set()
    for console_script in console_scripts(folder):
        (names if console_script.module == script.stem else claimed).add(console_script.name)
    for match in _RENAMED.finditer(read_or_nothing(folder / "CMakeLists.txt")):
        (names if Path(match["file"]).name == script.name else claimed).add(match["name"])
    if script.stem not in claimed:
        names.add(script.stem)
    return Program(script, package, frozenset(names - {""}))


def shown(paths: Sequence[Path], root: Path) -> tuple[str, ...]:
    """Return paths as messages name them: from the controller's root, each once, in their order."""
    return tuple(dict.fromkeys(from_root(root, path.resolve()) for path in paths))
