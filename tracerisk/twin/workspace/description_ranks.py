"""The order in which the files of a workspace are taken for the description of its robot."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from tracerisk.twin.robots.names_in_source import (
    LaunchedDescription,
    Spoken,
    words_of_one,
    words_shared,
)
from tracerisk.twin.urdf.srdf import Srdf
from tracerisk.twin.workspace.description_files import DescriptionFile, distance

_TESTS = frozenset({"test", "tests"})
_RANKS = {"controller": 0, "package": 1, "named": 2}
UNNAMED = 3
"""The rank of a file that no launch file near the controller names."""


class DescriptionRanks:
    """How likely each file describes the robot of which a controller speaks.

    `named` are the folders of the packages that the controller names, `launched` the descriptions
    of launch files by their files, `included` the names of the files that others include.
    """

    def __init__(
        self,
        spoken: Spoken,
        script: Path,
        named: Sequence[Path],
        launched: Mapping[Path, LaunchedDescription],
        included: Collection[str],
        urdf_files: Sequence[DescriptionFile],
    ) -> None:
        self._spoken = spoken
        self._script = script
        self._named = named
        self._launched = launched
        self._included = included
        self._urdf_files = urdf_files
        self.srdf_names: set[str] = set()
        self._variants: frozenset[str] = frozenset()

    def know_srdfs(self, names: set[str]) -> None:
        """Take the names of the robots of all SRDF files that were read."""
        self.srdf_names = names
        self._variants = words_of_one(names)

    def launched_as(self, file: DescriptionFile) -> int:
        """Return 0 for what the controller's launch file names, more for those less near to it."""
        launched = self._launched.get(file.path)
        return UNNAMED if launched is None else _RANKS.get(launched.by, UNNAMED)

    def is_meant(self, file: DescriptionFile) -> bool:
        """Return whether a file may describe the robot of which the controller speaks.

        Before macros are expanded that is seen from names in its text, its own name, and a package
        that the controller, its launch file or its manifest names.
        """
        in_named = bool(file.robot_name) and self.is_in_named(file)
        return in_named or self.is_first(file) or bool(self._spoken.among(file.words))

    def is_part(self, file: DescriptionFile) -> bool:
        """Return whether another file includes this one, which is then no whole robot."""
        return file.path.name in self._included and self.launched_as(file) == UNNAMED

    def is_in_named(self, file: DescriptionFile) -> bool:
        """Return whether a file is in a package that the controller names."""
        return any(file.path.resolve().is_relative_to(folder) for folder in self._named)

    def is_of_tests(self, file: DescriptionFile) -> bool:
        """Return whether a file belongs to tests of which the script is none."""
        return any(
            folder.name in _TESTS and not self._script.is_relative_to(folder)
            for folder in file.path.resolve().parents
        )

    def is_named(self, file: DescriptionFile) -> bool:
        """Return whether the controller names a file or its robot."""
        return bool({file.robot_name, file.stem} & self._spoken.words)

    def is_first(self, file: DescriptionFile) -> bool:
        """Return whether a launch file or the controller names a file or its robot."""
        return self.launched_as(file) != UNNAMED or self.is_named(file)

    def of_srdf(
        self, file: DescriptionFile, srdf: Srdf
    ) -> tuple[bool, bool, int, int, int, int, int, bool, bool, int, bool, int, str]:
        """Return what sorts an SRDF file among those of `know_srdfs`: the likeliest first."""
        is_other, is_folders_other = self._spoken.other_model(srdf.name, self.srdf_names)
        own = self._spoken.exactly_own(srdf.words)
        speaks = self._spoken.exactly(srdf.words)
        loud = {group.name for group in srdf.groups} & speaks
        states = {name for group in loud for name in srdf.states.get(group, {})}
        return (
            self.launched_as(file) != 0,
            is_other,
            -len(own),
            -len(loud),
            -len(states.intersection(self._spoken.strings)),
            -len(speaks),
            -len(words_shared(srdf.name, self._script.stem)),
            not self._spoken.asks_for(self._variants & {*srdf.name.split("_")}),
            is_folders_other,
            self.launched_as(file),
            not {srdf.name, file.stem} & self._spoken.words,
            distance(self._script, file.path),
            file.shown,
        )

    def of_urdf(
        self, file: DescriptionFile
    ) -> tuple[bool, bool, bool, int, bool, bool, int, bool, int, str]:
        """Return what sorts a URDF or xacro file among the others: the likeliest first."""
        names = {one.robot_name for one in self._urdf_files}
        return (
            self.launched_as(file) != 0,
            not self.is_named(file),
            any(self._spoken.other_model(file.robot_name, names)),
            self.launched_as(file),
            not self.is_in_named(file),
            self.is_part(file),
            -len(self._spoken.exactly(file.words)),
            file.path.name.endswith(".xacro"),
            distance(self._script, file.path),
            file.shown,
        )
