"""Find the robot of a controller's own workspace: its SRDF, and its URDF or xacro."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from tracerisk.errors import RobotError, TraceRiskError
from tracerisk.limited_process import DEFAULT_LIMITS, Limits
from tracerisk.twin.joint_limits import scaling_beside
from tracerisk.twin.known_arms import completed_as_ours, named_as_ours, shipped_like
from tracerisk.twin.mentions import Hint, decide
from tracerisk.twin.robot import Robot, load_robot
from tracerisk.twin.robot_index import shipped_names
from tracerisk.twin.srdf import Srdf, read_srdf
from tracerisk.twin.urdf import read_urdf
from tracerisk.twin.urdf_groups import groups_of, states_of
from tracerisk.twin.urdf_tree import tree_of
from tracerisk.twin.xacro_files import expanded_xacro

_MOST_FILES = 400
_MOST_FOLDERS = 4000
_DEEPEST = 8
_MOST_BYTES = 4 * 1024 * 1024
_MOST_EXPANDED = 8  # xacro files a controller; each costs up to a second
_NOT_SEARCHED = frozenset(
    {"build", "devel", "install", "log", "node_modules", "__pycache__", "venv"}
)
_TESTS = frozenset({"test", "tests"})
_FITS = 0.6  # the share of an SRDF's names that its URDF must have
_SHORTEST_STEM = 5  # `joint` alone says nothing about the arm
_ROBOT_NAME = re.compile(r"<robot\b[^>]*\bname\s*=\s*[\"']([^\"']+)[\"']", re.DOTALL)
_INCLUDE = re.compile(rb"<xacro:include\b[^>]*\bfilename\s*=\s*[\"']([^\"']+)[\"']")
_XACRO_ARGUMENT = re.compile(r"(\w+):=(\S+)")
# What so many robots call a part of theirs says nothing about which one it is.
_SAYS_NOTHING = frozenset({"world", "base", "base_link", "link", "tool0", "open", "close", "home"})


class UnreadableRobotError(RobotError):
    """The robot of the workspace is in a file that cannot be read."""


@dataclass(frozen=True, slots=True)
class NamedParts:
    """What a controller, its launch files and its manifest say about the workspace's robot."""

    packages: frozenset[str] = frozenset()
    """The packages that they name, the controller's own among them."""
    arguments: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """The arguments that a launch file gives a xacro file, by the file's name."""


@dataclass(frozen=True, slots=True)
class WorkspaceRobot:
    """What was found in a workspace: the robot and why it was taken, or `None`.

    `is_named` says that the controller names a part of it, or the robot itself.
    `skipped` are files that were looked at and not taken, each with its reason; `unreadable` those
    of them that the controller means and that cannot be read; `files` are those that the robot was
    read from.
    """

    robot: Robot | None
    reason: str
    skipped: tuple[str, ...] = ()
    is_named: bool = False
    files: tuple[Path, ...] = ()
    unreadable: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _File:
    path: Path
    shown: str
    text: bytes

    @property
    def words(self) -> frozenset[str]:
        """The names in the text, as far as they can be seen before macros are expanded."""
        names = re.findall(rb"name\s*=\s*[\"']([^\"'$]+)[\"']", self.text)
        return frozenset(name.decode(errors="replace") for name in names)

    @property
    def robot_name(self) -> str:
        found = _ROBOT_NAME.search(self.text.decode(errors="replace"))
        return found[1] if found else ""

    @property
    def stem(self) -> str:
        return self.path.name.split(".")[0]


def find_workspace_robot(
    roots: Iterable[Path],
    packages: Mapping[str, Path],
    strings: Iterable[str],
    script: Path,
    named: NamedParts | None = None,
    limits: Limits = DEFAULT_LIMITS,
) -> WorkspaceRobot:
    """Return the robot of the SRDF, URDF and xacro files below the roots.

    `packages` are the ROS packages that xacro files may find, `strings` those of the controller:
    of several robots the one is taken whose joints, as they are called when macros are expanded,
    the controller names most, then the one in a package that is `named`, then the one that is
    nearest to the script. A robot of which the controller names nothing is taken only if it is
    the only one; one of tests is not, unless the script is of them too.
    Raises LimitError where a xacro file takes too long or too much memory: which robot is taken
    must not depend on that.
    """
    search = _Search(tuple(roots), packages, strings, script, named or NamedParts(), limits)
    return search.run()


class _Search:
    def __init__(
        self,
        roots: tuple[Path, ...],
        packages: Mapping[str, Path],
        strings: Iterable[str],
        script: Path,
        named: NamedParts,
        limits: Limits,
    ) -> None:
        self._limits = limits
        self._packages = packages
        self._named = [packages[name].resolve() for name in named.packages if name in packages]
        self._arguments = named.arguments
        self._unreadable: list[str] = []
        self._words = _words(strings)
        self._script = script.resolve()
        self._skipped: list[str] = []
        self._expanded = 0
        self._read_for: dict[Path, tuple[Path, ...]] = {}
        files = [_read(path, roots) for path in _found(roots)]
        self._files = [file for file in files if file is not None]
        self._included = {
            name.rpartition(b"/")[2].decode(errors="replace")
            for file in self._files
            for name in _INCLUDE.findall(file.text)
        }

    def run(self) -> WorkspaceRobot:
        srdf_files = [file for file in self._files if ".srdf" in file.path.name]
        urdf_files = [
            file for file in self._files if ".srdf" not in file.path.name and b"<robot" in file.text
        ]
        for reader in (self._from_srdf, self._from_urdf):
            found = reader(srdf_files, urdf_files)
            if found is not None:
                robot, reason, taken = found
                parts = {joint.name for joint in robot.joints} | {robot.name, *robot.link_names}
                for group, states in robot.named_states.items():
                    parts |= {group, *states}
                is_named = bool((parts | set(robot.groups)) & self._words - _SAYS_NOTHING)
                if robot.assumes_names:
                    is_named = bool((parts - set(robot.groups)) & self._words - _SAYS_NOTHING)
                files = [path for file in taken for path in self._read_for.get(file.path, ())]
                read = tuple(dict.fromkeys([*(file.path for file in taken), *files]))
                if ".srdf" in taken[0].path.name:
                    robot, read = self._scaled(robot, taken[0], read)
                return WorkspaceRobot(robot, reason, tuple(self._skipped), is_named, read)
        why = "no URDF or SRDF stands in the workspace"
        if self._files:
            why = "no URDF or SRDF of the workspace describes a robot that the controller speaks of"
        return WorkspaceRobot(None, why, tuple(self._skipped), unreadable=tuple(self._unreadable))

    def _scaled(
        self, robot: Robot, srdf: _File, read: tuple[Path, ...]
    ) -> tuple[Robot, tuple[Path, ...]]:
        """Return the robot with the default scaling of the package that its SRDF is of."""
        try:
            found = scaling_beside(srdf.path, robot.default_scaling, shown=srdf.shown)
        except TraceRiskError as error:
            self._skipped.append(str(error))
            return robot, read
        if found is None:
            return robot, read
        scaling, path = found
        return replace(robot, default_scaling=scaling), (*read, path)

    def _from_srdf(
        self, srdf_files: list[_File], urdf_files: list[_File]
    ) -> tuple[Robot, str, tuple[_File, ...]] | None:
        read: list[tuple[_File, Srdf]] = []
        for file in sorted(srdf_files, key=self._rank):
            try:
                text = self._text(file)
                read.append((file, read_srdf(text, file.shown)))
            except RobotError as error:
                self._skip(file, error, is_meant=len(srdf_files) == 1 or self._is_meant(file))
        ranked = sorted(read, key=lambda each: self._srdf_rank(*each))
        only = len({srdf.name for file, srdf in read if not self._is_of_tests(file)}) == 1
        for file, srdf in ranked:
            speaks = sorted((srdf.words & self._words) - _SAYS_NOTHING)
            if not speaks and (not only or self._is_of_tests(file)):
                self._skipped.append(f"{file.shown}: the controller names nothing of it")
                continue
            why = f"names {', '.join(speaks[:4])}" if speaks else "it is the only one"
            found = self._urdf_for(file, srdf, urdf_files)
            if found is not None:
                robot, urdf = found
                told = f"{file.shown} with {urdf.shown} in the workspace ({why})"
                return robot, told, (file, urdf)
            like = shipped_like(srdf.words)
            if len(like) > 1:
                like = self._named_of(like, file, srdf)
            if len(like) == 1:
                completed = _with_srdf(load_robot(like[0]), srdf)
                told = f"{file.shown} in the workspace ({why}), the arm from {like[0]}"
                return completed, told, (file,)
            told = f"several known robots have its joints: {', '.join(like)}"
            self._skipped.append(
                f"{file.shown}: {told if like else 'no URDF or known robot has its joints'}"
            )
        return None

    def _named_of(self, names: Sequence[str], file: _File, srdf: Srdf) -> tuple[str, ...]:
        """Return those of several robots that the SRDF or its path names, else the controller."""
        hints = (
            Hint("the SRDF", {file.shown: f"{srdf.name} {file.shown}"}),
            Hint("its source", {self._script.name: " ".join((self._script.stem, *self._words))}),
        )
        return decide(names, {each.name: each for each in shipped_names()}, hints).left

    def _urdf_for(
        self, file: _File, srdf: Srdf, urdf_files: list[_File]
    ) -> tuple[Robot, _File] | None:
        named, arguments = self._named_by_assistant(file)

        def rank(urdf: _File) -> tuple[bool, bool, bool, int, int, str]:
            return (
                urdf.path != named,
                srdf.name not in (urdf.robot_name, urdf.stem),
                file.stem != urdf.stem,
                -len(srdf.words & urdf.words),
                _distance(file.path, urdf.path),
                urdf.shown,
            )

        for urdf in sorted(urdf_files, key=rank):
            is_near = urdf.path == named or srdf.name in (urdf.robot_name, urdf.stem)
            if not is_near and not srdf.words & urdf.words:
                continue
            try:
                text = self._text(urdf, arguments if urdf.path == named else None)
                robot = read_urdf(text, urdf.shown, srdf=srdf)
            except RobotError as error:
                self._skip(urdf, error)
                continue
            has = {*robot.link_names, *(one.name for one in robot.attachments)}
            asked = _parts(srdf)
            if asked and len(asked & has) < _FITS * len(asked):
                continue
            if not any(group in robot.groups for group in (one.name for one in srdf.groups)):
                continue
            return completed_as_ours(robot), urdf
        return None

    def _named_by_assistant(self, file: _File) -> tuple[Path | None, dict[str, str]]:
        """Return the file, with its arguments, from which MoveIt's assistant made an SRDF."""
        for folder in list(file.path.parents)[:2]:
            try:
                text = (folder / ".setup_assistant").read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue
            package, relative, given = (
                re.search(rf"^\s*{key}:[ \t]*(.*)$", text, re.MULTILINE)
                for key in ("package", "relative_path", "xacro_args")
            )
            if package and relative:
                place = self._packages.get(package[1].strip().strip("\"'"))
                arguments = dict(_XACRO_ARGUMENT.findall(given[1])) if given else {}
                if place is not None:
                    return place / relative[1].strip().strip("\"'"), arguments
        return None, {}

    def _from_urdf(
        self, _srdf_files: list[_File], urdf_files: list[_File]
    ) -> tuple[Robot, str, tuple[_File, ...]] | None:
        names_of = {file.robot_name for file in urdf_files if not self._is_of_tests(file)}
        best: tuple[tuple[int, int], Robot, str, _File] | None = None
        for file in sorted(urdf_files, key=self._rank):
            only = len(names_of) == 1 and not self._is_of_tests(file)
            if not only and not self._is_meant(file):
                continue
            try:
                text = self._text(file)
            except RobotError as error:
                self._skip(file, error, is_meant=not self._is_part(file))
                continue
            try:
                robot = read_urdf(text, file.shown)
            except RobotError as error:
                is_meant = bool(self._spoken(file.words)) and not self._is_part(file)
                self._skip(file, error, is_meant=is_meant)
                continue
            joints = {one.name for one in robot.joints}
            of_joints = self._spoken(joints)
            speaks = of_joints | self._spoken(set(robot.link_names))
            if not speaks and not only and not self._is_named(file):
                continue
            weight = (len(of_joints), len(speaks))
            if best is None or weight > best[0]:
                why = f"names {', '.join(sorted(speaks)[:4])}" if speaks else "by its name"
                best = weight, robot, why, file
            if {one.name for one in robot.arm_joints} <= of_joints:
                break
        if best is None:
            return None
        _, robot, why, file = best
        completed = named_as_ours(completed_as_ours(robot))
        return completed, f"{file.shown} in the workspace ({why})", (file,)

    def _spoken(self, names: Set[str]) -> Set[str]:
        """Return the names that the controller names, also as a stem before a number."""
        return {
            name
            for name in names - _SAYS_NOTHING
            if name in self._words
            or (
                (stem := name.rstrip("0123456789")) in self._words
                and stem != name
                and len(stem.rstrip("_")) > _SHORTEST_STEM
            )
        }

    def _is_meant(self, file: _File) -> bool:
        """Tell whether a file may describe the robot of which the controller speaks.

        Before macros are expanded that is seen from names in its text, its own name, and a package
        that the controller, its launch file or its manifest names.
        """
        in_named = bool(file.robot_name) and self._is_in_named(file)
        return bool(self._spoken(file.words)) or self._is_named(file) or in_named

    def _is_part(self, file: _File) -> bool:
        """Tell whether another file includes this one, which is then no whole robot."""
        return file.path.name in self._included

    def _is_in_named(self, file: _File) -> bool:
        return any(file.path.resolve().is_relative_to(folder) for folder in self._named)

    def _is_of_tests(self, file: _File) -> bool:
        """Tell whether a file belongs to tests of which the script is none."""
        return any(
            folder.name in _TESTS and not self._script.is_relative_to(folder)
            for folder in file.path.resolve().parents
        )

    def _is_named(self, file: _File) -> bool:
        return bool({file.robot_name, file.stem} & self._words)

    def _srdf_rank(self, file: _File, srdf: Srdf) -> tuple[int, int, bool, int, str]:
        speaks = (srdf.words & self._words) - _SAYS_NOTHING
        loud = {group.name for group in srdf.groups} & speaks
        return (
            -len(loud),
            -len(speaks),
            not {srdf.name, file.stem} & self._words,
            _distance(self._script, file.path),
            file.shown,
        )

    def _rank(self, file: _File) -> tuple[bool, bool, int, bool, bool, int, str]:
        return (
            not self._is_in_named(file),
            self._is_part(file),
            -len((file.words & self._words) - _SAYS_NOTHING),
            not self._is_named(file),
            file.path.name.endswith(".xacro"),
            _distance(self._script, file.path),
            file.shown,
        )

    def _text(self, file: _File, arguments: Mapping[str, str] | None = None) -> bytes:
        is_macro = file.path.name.endswith(".xacro") or b"<xacro:" in file.text
        if not is_macro:
            return file.text
        if self._expanded >= _MOST_EXPANDED:
            raise RobotError(f"not looked at: {_MOST_EXPANDED} xacro files were expanded before it")
        self._expanded += 1
        if arguments is None:
            arguments = self._arguments.get(file.path.name)
        expanded = expanded_xacro(
            file.path,
            self._packages,
            arguments=arguments,
            shown=file.shown,
            limits=self._limits,
        )
        self._read_for[file.path] = expanded.files
        return expanded.text

    def _skip(self, file: _File, error: TraceRiskError, *, is_meant: bool = False) -> None:
        self._skipped.append(f"{file.shown}: {error.message}")
        if is_meant and not self._is_of_tests(file):
            self._unreadable.append(self._skipped[-1])


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
            elif name.endswith((".srdf", ".urdf", ".xacro")) and entry.is_file():
                count += 1
                if count > _MOST_FILES:
                    return
                yield Path(entry.path)


def _read(path: Path, roots: tuple[Path, ...]) -> _File | None:
    try:
        if path.stat().st_size > _MOST_BYTES:
            return None
        text = path.read_bytes()
    except OSError:
        return None
    top = next((root for root in roots if path.is_relative_to(root.resolve())), None)
    shown = path.name if top is None else path.relative_to(top.resolve()).as_posix()
    return _File(path, shown, text)


def _words(strings: Iterable[str]) -> frozenset[str]:
    words: set[str] = set()
    for string in strings:
        words.add(string)
        words.update(part for part in re.split(r"[/\s,;:.]+", string) if part)
    return frozenset(words)


def _distance(one: Path, other: Path) -> int:
    """Return how many folders lie between two files."""
    shared = 0
    for left, right in zip(one.parts, other.parts, strict=False):
        if left != right:
            break
        shared += 1
    return len(one.parts) + len(other.parts) - 2 * shared


def _parts(srdf: Srdf) -> set[str]:
    names: set[str] = set()
    for group in srdf.groups:
        names.update(group.joints, group.links, *group.chains)
    return names


def _with_srdf(robot: Robot, srdf: Srdf) -> Robot:
    """Return a shipped robot with the groups and states of an SRDF beside its own."""
    joints = {joint.name: joint for joint in robot.joints}
    groups = {**robot.groups, **groups_of(tree_of(robot), srdf)}
    states = {**robot.named_states}
    for group, found in states_of(srdf, groups, joints).items():
        states[group] = MappingProxyType({**states.get(group, {}), **found})
    return replace(
        robot,
        groups=MappingProxyType(groups),
        named_states=MappingProxyType(states),
        disabled_collisions=robot.disabled_collisions | srdf.disabled_collisions,
    )
