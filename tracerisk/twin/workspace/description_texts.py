"""The texts of the files that describe robots, with macros expanded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tracerisk.errors import RobotError
from tracerisk.limits import Limits
from tracerisk.twin.robots.names_in_source import LaunchedDescription
from tracerisk.twin.urdf.xacro_files import Expanded, expanded_xacro
from tracerisk.twin.workspace.description_files import DescriptionFile

_MOST_EXPANDED = 12  # xacro files a controller; each costs up to a second
_MOST_TRIED = 40  # with those that cannot be expanded: parts of others, which end soon
_ROBOTS_NAME = "name"  # the argument of xacro that many files want and give no default
_Key = tuple[Path, tuple[tuple[str, str], ...]]


@dataclass(eq=False)
class DescriptionTexts:
    """Expands each file once, with what a launch file gives xacro for it.

    `_packages` are those that a file may find, `_launched` what launch files give.
    """

    _packages: Mapping[str, Path]
    _launched: Mapping[Path, LaunchedDescription]
    _limits: Limits
    _expanded: dict[_Key, Expanded | RobotError] = field(default_factory=dict)
    _read_for: dict[Path, tuple[Path, ...]] = field(default_factory=dict)

    def of(self, file: DescriptionFile, arguments: Mapping[str, str] | None = None) -> bytes:
        """Return the XML of a file; `arguments` are for xacro where no launch file gives any.

        Raises RobotError where it cannot be expanded, or too many were before it; LimitError
        where that takes too long or too much memory.
        """
        if not file.is_macro:
            return file.text
        launched = self._launched.get(file.path)
        given = dict(launched.arguments) if launched is not None else dict(arguments or {})
        key = (file.path, tuple(sorted(given.items())))
        if key not in self._expanded:
            expanded = sum(isinstance(each, Expanded) for each in self._expanded.values())
            if expanded >= _MOST_EXPANDED or len(self._expanded) >= _MOST_TRIED:
                raise RobotError(
                    f"not looked at: {len(self._expanded)} xacro files were tried before it, of "
                    f"which {expanded} could be expanded"
                )
            try:
                self._expanded[key] = self._expand_named(file, given)
            except RobotError as error:
                self._expanded[key] = error
        found = self._expanded[key]
        if isinstance(found, RobotError):
            raise found
        self._read_for[file.path] = found.files
        return found.text

    def read_for(self, file: DescriptionFile) -> tuple[Path, ...]:
        """Return the files that were read for one, none where it was not expanded."""
        return self._read_for.get(file.path, ())

    def _expand_named(self, file: DescriptionFile, given: Mapping[str, str]) -> Expanded:
        try:
            return self._expand(file, given)
        except RobotError as error:
            # What the robot is called is no matter of which robot it is.
            if not error.message.endswith(f" {_ROBOTS_NAME}"):
                raise
            return self._expand(file, {**given, _ROBOTS_NAME: file.stem})

    def _expand(self, file: DescriptionFile, given: Mapping[str, str]) -> Expanded:
        return expanded_xacro(
            file.path, self._packages, arguments=given, shown=file.shown, limits=self._limits
        )
