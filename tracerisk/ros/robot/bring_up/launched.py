"""Which controllers files of the workspace say that are started, or loaded without a start.

They are read as text, for what counts is written in launch files of three formats, in shell scripts
and in the commands of a README.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path

from tracerisk.common.text.bounded import file_text

_MOST_FILES = 300
_MOST_BYTES = 200_000
_NAMES = re.compile(r"\.launch(\.py|\.xml|\.yaml)?$|launch.*\.py$|\.sh$|\.bash$|\.md$|\.rst$")
_SOURCES = re.compile(r"\.py$|^package\.xml$")  # a program of a simulator asks for its services
_STARTS = re.compile(
    r"spawner|spawn\b|initial_joint_controller|activate_joint_controller|switch_controller"
    r"|set_controller_state|load_controller|--activate|--start|start_controllers"
    r"|activate_controllers|name=[\"']controllers[\"']",
)
_SIMULATES = re.compile(
    r"gazebo|gz_sim|ros_gz|ros_ign|ur_simulation|webots|isaac|mujoco|coppelia"
    r"|ros2_control_node",
    re.IGNORECASE,
)
_HELD = ("--inactive", "--stopped", "--load-only", "stopped_controllers")


class LaunchedControllers:
    """What the workspace's files say of starting controllers and nodes."""

    def __init__(self, folders: Iterable[Path], script: Path | None = None) -> None:
        """`script` is the program that runs, which may lie in none of the folders."""
        folders = tuple(folders)
        self._texts = tuple(islice(_texts(folders, _NAMES), _MOST_FILES))
        own = () if script is None else _read([script], _SOURCES)
        self._sources = (*own, *islice(_texts(folders, _SOURCES), _MOST_FILES))
        # A stream of set points asks for each of them.
        self._named: dict[str, bool] = {}

    @property
    def has_own_bring_up(self) -> bool:
        """Whether a file starts the robot otherwise than by its driver: by a simulator, say."""
        return any(_SIMULATES.search(text) for text in (*self._texts, *self._sources))

    def name(self, word: str) -> bool:
        """Whether a file or a program names a package or a controller."""
        named = self._named.get(word)
        if named is None:
            pattern = re.compile(rf"(?<!\w){re.escape(word)}(?!\w)")
            named = any(pattern.search(text) for text in (*self._texts, *self._sources))
            self._named[word] = named
        return named

    def command(self, controller: str) -> bool:
        """Whether a program has a text that is a controller, or a topic or an action below it.

        A package that is called as the controller is, and a type of its controllers, are none.
        """
        text = rf"[\"'/]{re.escape(controller)}([\"']|/(?!\w+Controller\b))"
        return any(re.search(text, source) for source in self._sources)

    def call(self, service: str) -> bool:
        """Whether a file names a service, which somebody calls then beside the controller."""
        return any(service in text for text in self._texts)

    def starts(self, name: str) -> bool:
        """Whether a file that starts or switches controllers names this one, and not to hold it."""
        word = re.compile(rf"(?<![\w/]){re.escape(name)}(?![\w/])")
        for text in self._texts:
            if not _STARTS.search(text):
                continue
            for match_ in word.finditer(text):
                line = _line(text, match_.start())
                if not any(held in line for held in _HELD):
                    return True
        return False


def _line(text: str, at: int) -> str:
    start, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
    return text[start : len(text) if end < 0 else end]


def _texts(folders: Iterable[Path], names: re.Pattern[str]) -> Iterator[str]:
    roots: dict[Path, None] = {}
    for top in folders:
        if top.parent.name == "src":
            # What a README beside `src` says is said of the whole workspace.
            roots[top.parent.parent] = None
        for folder, inner, files in os.walk(top):
            inner[:] = sorted(name for name in inner if not name.startswith("."))
            yield from _read((Path(folder, file) for file in sorted(files)), names)
    for root in roots:
        # Nobody asked for this folder: where a contained run may not list it, that is no finding
        # on the controller, as it is where `os.listdir` is refused.
        with suppress(OSError), os.scandir(root) as entries:
            yield from _read(sorted(Path(one.path) for one in entries if one.is_file()), names)


def _read(paths: Iterable[Path], names: re.Pattern[str]) -> Iterator[str]:
    for path in paths:
        try:
            if names.search(path.name) and path.stat().st_size <= _MOST_BYTES:
                yield file_text(path, errors="replace")
        except OSError:
            continue  # nobody may read it, or it is a link to nowhere
