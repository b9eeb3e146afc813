"""The texts of the files that describe robots, with macros expanded."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from tracerisk.common.limits import Limits
from tracerisk.errors import RobotError
from tracerisk.twin.robots.names_in_source import LaunchedDescription
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.urdf.xacro_files import Expanded, LackingError, expanded_xacro
from tracerisk.twin.workspace.absent_macros import Completed, with_shipped_robots
from tracerisk.twin.workspace.description_files import DescriptionFile

_MOST_EXPANDED = 12  # xacro files of each kind; each costs up to a second
_MOST_TRIED = 40  # with those that cannot be expanded: parts of others, which end soon
_ROBOTS_NAME = "name"  # the argument of xacro that many files want and give no default
_MOVES = re.compile(rb"<joint\b[^>]*type=[\"'](?:revolute|continuous|prismatic)")
_OLD = "its xacro has forms of older releases (tags without prefix, `__name`), read as then"
_Key = tuple[Path, tuple[tuple[str, str], ...]]
_Kind = tuple[bool, bool]
"""Whether files are SRDF, and whether anything names them."""


@dataclass(eq=False)
class DescriptionTexts:
    """Expands each file once, with what a launch file gives xacro for it."""

    _packages: Mapping[str, Path]
    """The folders of the packages that a file may find, by package name."""
    _launched: Mapping[Path, LaunchedDescription]
    """What launch files give, by description file."""
    _limits: Limits
    """The limits on time and memory of an expansion."""
    _expanded: dict[_Key, Expanded | RobotError] = field(default_factory=dict)
    """The expanded text or the error, by file and arguments."""
    _counted: dict[_Kind, list[_Key]] = field(default_factory=dict)
    """The files expanded so far, by (is an SRDF, is named by something)."""
    _read_for: dict[Path, tuple[Path, ...]] = field(default_factory=dict)
    """The files that were read to expand a file."""
    _completed: dict[Path, Completed] = field(default_factory=dict)
    """The files in which absent parts were replaced or left out."""

    def of(
        self,
        file: DescriptionFile,
        arguments: Mapping[str, str] | None = None,
        *,
        is_named: bool = False,
    ) -> bytes:
        """Return the XML of a file; `arguments` are for xacro where no launch file gives any.

        A file that something names (`is_named`) is read however many others were: they are
        counted apart, and so are SRDF files.
        Raises RobotError where it cannot be expanded, or too many were before it; LimitError
        where that takes too long or too much memory.
        """
        if not file.is_macro:
            return file.text
        launched = self._launched.get(file.path)
        given = dict(launched.arguments) if launched is not None else dict(arguments or {})
        key = (file.path, tuple(sorted(given.items())))
        if key not in self._expanded:
            before = self._counted.setdefault((file.is_srdf, is_named), [])
            expanded = sum(isinstance(self._expanded[one], Expanded) for one in before)
            if expanded >= _MOST_EXPANDED or len(before) >= _MOST_TRIED:
                raise RobotError(f"skipped after {len(before)} xacro files ({expanded} expanded)")
            before.append(key)
            try:
                self._expanded[key] = self._expand_named(file, given)
            except RobotError as error:
                self._expanded[key] = error
        result = self._expanded[key]
        if isinstance(result, RobotError):
            raise result
        self._read_for[file.path] = result.files
        return result.text

    def read_for(self, file: DescriptionFile) -> tuple[Path, ...]:
        """Return the files that were read for one, none where it was not expanded."""
        return self._read_for.get(file.path, ())

    def is_without_parts(self, file: DescriptionFile) -> bool:
        """Return whether something of absent packages was left out or replaced in a file."""
        return file.path in self._completed

    def completed(self, robot: Robot, file: DescriptionFile) -> Robot:
        """Return the robot of a file with what was assumed to read it."""
        done = self._completed.get(file.path)
        if done is None:
            return robot
        return replace(
            robot,
            assumed_figures=(*robot.assumed_figures, *done.notes),
            doubt="; ".join(doubt for doubt in (robot.doubt, *done.doubts) if doubt),
        )

    def _expand_named(self, file: DescriptionFile, given: Mapping[str, str]) -> Expanded:
        try:
            expand = self._expand(file, given)
            if expand.is_old:
                self._completed[file.path] = Completed(expand.text, (_OLD,), ())
            return expand
        except LackingError as error:
            # What a launch file gives for another file is given here too; what the robot is
            # called is no matter of which robot it is.
            elsewhere = {
                name: value
                for description in self._launched.values()
                for name, value in description.arguments
            }
            known = {_ROBOTS_NAME: file.stem, **elsewhere, **given}
            expand = self._expand(file, known, may_lack=True)
            is_whole = not expand.packages and not expand.arguments
            return expand if is_whole else self._completed_of(file, expand, error)

    def _completed_of(
        self, file: DescriptionFile, found: Expanded, error: LackingError
    ) -> Expanded:
        """Return the file with shipped robots for what is absent.

        Raises `error` where no joint of an arm is left.
        """
        done = with_shipped_robots(found.text, found.packages, found.includes)
        if not _MOVES.search(done.text):
            raise error
        if found.arguments:
            empty = ", ".join(found.arguments)
            doubt = f"nothing here gives {file.shown} its {empty}: taken for empty, or for 0"
            done = replace(done, doubts=(*done.doubts, doubt))
        if found.is_old:
            done = replace(done, notes=(*done.notes, _OLD))
        self._completed[file.path] = done
        return replace(found, text=done.text)

    def _expand(
        self, file: DescriptionFile, given: Mapping[str, str], *, may_lack: bool = False
    ) -> Expanded:
        return expanded_xacro(
            file.path,
            self._packages,
            arguments=given,
            shown=file.shown,
            limits=self._limits,
            may_lack=may_lack,
        )
