"""Find the robot of a controller's own workspace: its SRDF, and its URDF or xacro."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from tracerisk.common.limits import DEFAULT_LIMITS, Limits
from tracerisk.errors import RobotError, TraceRiskError
from tracerisk.twin.robots.generic import is_finger_name
from tracerisk.twin.robots.known_arms import (
    completed_as_ours,
    is_variant,
    named_as_ours,
    shipped_like,
)
from tracerisk.twin.robots.names_in_source import (
    LaunchedDescription,
    Spoken,
)
from tracerisk.twin.robots.prefix import prefix_before, prefix_left_out, with_prefix, without_prefix
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.urdf.moveit_package import PACKAGE_FILES, changed_as_beside
from tracerisk.twin.urdf.srdf import Srdf, read_srdf
from tracerisk.twin.urdf.tree import NoWholeRobotError
from tracerisk.twin.urdf.urdf import read_urdf
from tracerisk.twin.workspace.described_robots import DescribedRobot, WorkspaceRobots
from tracerisk.twin.workspace.description_files import (
    DescriptionFile,
    description_files,
    read_description,
)
from tracerisk.twin.workspace.description_ranks import UNNAMED, DescriptionRanks
from tracerisk.twin.workspace.description_texts import DescriptionTexts
from tracerisk.twin.workspace.srdf_pairing import (
    UrdfChoice,
    has_parts_of,
    needed_packages,
    setup_assistant,
    shipped_with_srdf,
)
from tracerisk.twin.workspace.taken_description import Taken, among_rivals, doubted


def find_workspace_robots(
    roots: Iterable[Path],
    packages: Mapping[str, Path],
    spoken: Spoken,
    script: Path,
    limits: Limits = DEFAULT_LIMITS,
) -> WorkspaceRobots:
    """Return the robots of the SRDF, URDF and xacro files below the roots that may be meant.

    `packages` are the ROS packages that xacro files may find. Reading a file may cost a second, so
    files are looked at in the order of what their texts show: first the one that the controller's
    launch file describes, then the one that the controller names exactly, then the one of whose
    groups, states and joints it names most, then by other launch files and by how near they are.
    A robot of tests is not looked at, unless the script is of them too.
    Raises LimitError where a xacro file takes too long or too much memory: which robot is taken
    must not depend on that.
    """
    return _Search(tuple(roots), packages, spoken, script, limits).run()


class _Search:
    def __init__(
        self,
        roots: tuple[Path, ...],
        packages: Mapping[str, Path],
        spoken: Spoken,
        script: Path,
        limits: Limits,
    ) -> None:
        self._packages = packages
        self._spoken = spoken
        self._skipped: list[str] = []
        self._unreadable: list[str] = []
        self._launched: dict[Path, LaunchedDescription] = {}
        for description in spoken.described:
            if description.path is not None:
                self._launched.setdefault(description.path, description)
        self._texts = DescriptionTexts(packages, self._launched, limits)
        self._files = description_files(roots)
        known = {file.path for file in self._files}
        launched = (read_description(path, roots) for path in self._launched if path not in known)
        self._files += [file for file in launched if file is not None]
        self._urdf_files = [file for file in self._files if file.is_robot and not file.is_srdf]
        self._ranks = DescriptionRanks(
            spoken,
            script.resolve(),
            [packages[name].resolve() for name in spoken.packages if name in packages],
            self._launched,
            frozenset[str]().union(*(file.included for file in self._files)),
            self._urdf_files,
        )

    def run(self) -> WorkspaceRobots:
        described_robots = [taken for taken in (self._from_srdf(),) if taken is not None]
        if not described_robots or self._lacks_joints(described_robots[0].robot):
            described_robots += [taken for taken in (self._from_urdf(),) if taken is not None]
        for description in self._spoken.described:
            if description.problem and description.by == "controller":
                self._unreadable.append(f"{description.file}: {description.problem}")
        described = tuple(map(self._described, described_robots))
        return WorkspaceRobots(
            described, tuple(self._skipped), tuple(dict.fromkeys(self._unreadable))
        )

    def _lacks_joints(self, robot: Robot) -> bool:
        """Return whether the controller lists joints of an arm that a robot has not."""
        listed = {name for name in self._spoken.joints if not is_finger_name(name)}
        return not listed <= {joint.name for joint in robot.joints}

    def _described(self, found: Taken) -> DescribedRobot:
        robot = found.robot
        files = [path for file in found.files for path in self._texts.read_for(file)]
        read = tuple(dict.fromkeys([*(file.path for file in found.files), *files]))
        if found.files[0].is_srdf:
            robot, read = self._limited(robot, found.files[0], read)
        near = min(found.files, key=self._ranks.launched_as)
        launched = self._launched.get(near.path)
        return DescribedRobot(
            robot=robot,
            reason=found.reason,
            key=found.files[0].shown,
            files=read,
            launched_by=None if launched is None else launched.by,
            launch_file="" if launched is None else launched.file,
            is_near=any(map(self._ranks.is_in_named, found.files)),
            is_called=any(map(self._ranks.is_named, found.files)),
            is_only=found.is_only,
            srdf=found.srdf,
            like=found.like,
            prefix=found.prefix,
        )

    def _limited(
        self, robot: Robot, srdf: DescriptionFile, read: tuple[Path, ...]
    ) -> tuple[Robot, tuple[Path, ...]]:
        """Return the robot with the limits and solvers of the MoveIt package of its SRDF."""
        for name in PACKAGE_FILES:
            try:
                robot, path = changed_as_beside(robot, srdf.path, name, shown=srdf.shown)
            except TraceRiskError as error:
                self._skipped.append(str(error))
                continue
            read = read if path is None else (*read, path)
        return robot, read

    def _from_srdf(self) -> Taken | None:
        files = [file for file in self._files if file.is_srdf]
        read: list[tuple[DescriptionFile, Srdf]] = []
        for file in sorted(files, key=self._ranks.of_urdf):
            try:
                text = self._texts.of(file, is_named=self._ranks.is_first(file))
                read.append((file, read_srdf(text, file.shown)))
            except RobotError as error:
                self._skip(
                    file, error.message, is_meant=len(files) == 1 or self._ranks.is_meant(file)
                )
        self._ranks.know_srdfs({srdf.name for _, srdf in read})
        ranked = sorted(read, key=lambda pair: self._ranks.of_srdf(*pair))
        only = len({srdf.name for file, srdf in read if not self._ranks.is_of_tests(file)}) == 1
        for place, (file, srdf) in enumerate(ranked):
            speaks = sorted(self._spoken.exactly(srdf.words))
            starts = self._ranks.launched_as(file) == 0
            # Each arm's group may be called so: of what is there for tests, a part must be named.
            is_of_tests = self._ranks.is_of_tests(file)
            speaks_of_groups = {group.name for group in srdf.groups}.issuperset(speaks)
            if is_of_tests and speaks_of_groups and not self._ranks.is_first(file):
                speaks = []
            if not speaks and not starts and (not only or is_of_tests):
                self._skipped.append(f"{file.shown}: the controller names nothing of it")
                continue
            why = f"names {', '.join(speaks[:4])}" if speaks else "it is the only one"
            is_only = only and not is_of_tests
            if starts and not speaks:
                why = f"by {self._launched[file.path].file}"
            result = self._urdf_for(file, srdf)
            if result is not None:
                robot, urdf = result
                robot = among_rivals(robot, self._as_likely((file, srdf), ranked[place + 1 :]))
                origin = f"{file.shown} with {urdf.shown} in the workspace ({why})"
                return Taken(robot, origin, (file, urdf), is_only=is_only)
            like, prefix = shipped_like(srdf.words)
            if like:
                origin = f"{file.shown} in the workspace ({why})"
                robot = shipped_with_srdf(like[0], prefix, srdf)
                return Taken(
                    robot, origin, (file,), is_only=is_only, srdf=srdf, like=like, prefix=prefix
                )
            origin = f"no URDF or known robot has its joints{self._absent(file)}"
            self._skip(file, origin, is_meant=bool(speaks) or starts)
        return None

    def _as_likely(
        self, taken: tuple[DescriptionFile, Srdf], others: Sequence[tuple[DescriptionFile, Srdf]]
    ) -> Iterator[str]:
        """Yield the SRDF files of other robots that only their names put behind the one taken."""
        rank = self._ranks.of_srdf(*taken)[:-1]
        for file, srdf in others:
            is_other = srdf.name != taken[1].name and not self._ranks.is_of_tests(file)
            if is_other and self._ranks.of_srdf(file, srdf)[:-1] == rank:
                yield file.shown

    def _absent(self, srdf: DescriptionFile) -> str:
        """Return which package of the robot's links and joints is not here; empty for none."""
        noted = setup_assistant(srdf.path)
        if noted is not None and noted.package not in self._packages:
            absent = f"package '{noted.package}', which describes them"
            return f"; {absent}, is neither in the workspace nor installed"
        return ""

    def _urdf_for(self, file: DescriptionFile, srdf: Srdf) -> tuple[Robot, DescriptionFile] | None:
        noted = setup_assistant(file.path)
        needed = needed_packages(file.path, self._packages)
        choice = UrdfChoice(file, srdf, noted, self._packages, needed)
        others = self._ranks.srdf_names - {srdf.name}
        ranked = sorted(
            self._urdf_files,
            key=lambda urdf: (
                self._ranks.launched_as(urdf) != 0,
                not choice.is_noted(urdf),
                bool({urdf.robot_name, urdf.stem} & others),
                self._ranks.launched_as(urdf),
                *choice.rank(urdf),
            ),
        )
        broken: list[str] = []
        for urdf in ranked:
            is_near = self._ranks.launched_as(urdf) != UNNAMED or choice.is_near(urdf)
            if not is_near and (self._ranks.is_part(urdf) or not choice.is_needed(urdf)):
                continue
            try:
                is_named = self._ranks.is_first(urdf) or choice.is_named(urdf)
                text = self._texts.of(urdf, choice.arguments(urdf), is_named=is_named)
                robot = read_urdf(text, urdf.shown, srdf=srdf)
            except RobotError as error:
                # Another arm of the same joints may stand elsewhere, but it is not this one.
                self._skip(urdf, error.message, is_meant=self._ranks.launched_as(urdf) == 0)
                broken += [urdf.shown] if choice.is_named(urdf) else []
                continue
            if has_parts_of(robot, srdf, lacks_parts=self._texts.is_without_parts(urdf)):
                beside = [file for file in ranked if file != urdf and choice.is_near(file)]
                rivals = () if is_named else self._alike(robot, beside, srdf)
                completed = self._texts.completed(completed_as_ours(robot), urdf)
                if broken and not is_named:
                    words = f"has the name of {file.shown} and cannot be read"
                    completed = doubted(completed, f"{broken[0]} {words}; name it with --robot")
                return among_rivals(completed, rivals), urdf
        return None

    def _from_urdf(self) -> Taken | None:
        names_of = {
            file.robot_name for file in self._urdf_files if not self._ranks.is_of_tests(file)
        }
        best: tuple[tuple[bool, int, int, bool, int], Taken] | None = None
        for file in sorted(self._urdf_files, key=self._ranks.of_urdf):
            starts = self._ranks.launched_as(file) == 0
            only = len(names_of) == 1 and not self._ranks.is_of_tests(file)
            if not only and not starts and not self._ranks.is_meant(file):
                continue
            try:
                text = self._texts.of(file, is_named=self._ranks.is_first(file))
            except RobotError as error:
                self._skip(file, error.message, is_meant=not self._ranks.is_part(file))
                continue
            try:
                robot = read_urdf(text, file.shown)
                prefix, left_out = self._prefixes_of(robot)
            except RobotError as error:
                is_meant = starts or bool(self._spoken.among(file.words))
                is_whole = not self._ranks.is_part(file) and not isinstance(
                    error, NoWholeRobotError
                )
                is_meant = is_meant and is_whole
                self._skip(file, error.message, is_meant=is_meant)
                continue
            prefixed = f", all with the prefix '{prefix}'" if prefix else ""
            robot = with_prefix(robot, prefix) if prefix else robot
            named = {one.name.removeprefix(left_out) for one in robot.joints}
            of_joints = self._spoken.among(named)
            speaks = of_joints | self._spoken.among(set(robot.link_names))
            if not speaks and not only and not starts and not self._ranks.is_named(file):
                continue
            own = len(self._spoken.exactly_own(named))
            weight = (starts, own, len(of_joints), self._ranks.is_named(file), len(speaks))
            if best is None or weight > best[0]:
                why = f"names {', '.join(sorted(speaks)[:4])}" if speaks else "by its name"
                if starts and not speaks:
                    why = f"by {self._launched[file.path].file}"
                best = weight, Taken(robot, f"{why}{prefixed}", (file,), left_out, only)
            is_whole = {one.name.removeprefix(left_out) for one in robot.arm_joints} <= of_joints
            if is_whole and of_joints >= self._spoken.exactly(self._spoken.joints):
                break
        if best is None:
            return None
        taken = best[1]
        grouped = named_as_ours(completed_as_ours(taken.robot))
        completed = self._texts.completed(grouped, taken.files[0])
        if taken.left_out:
            origin = f"the controller names its joints without the prefix '{taken.left_out}'"
            completed = doubted(without_prefix(completed, taken.left_out), origin)
        else:
            equal = self._ranks.of_urdf(taken.files[0])[:-1]
            others = [file for file in self._urdf_files if self._ranks.of_urdf(file)[:-1] == equal]
            completed = among_rivals(completed, self._alike(taken.robot, others))
        origin = f"{taken.files[0].shown} in the workspace ({taken.reason})"
        return replace(taken, robot=completed, reason=origin)

    def _alike(
        self, robot: Robot, files: Iterable[DescriptionFile], srdf: Srdf | None = None
    ) -> Iterator[str]:
        """Yield which of some files are of other arms with the same joints."""
        for file in files:
            with contextlib.suppress(RobotError):
                if is_variant(read_urdf(self._texts.of(file), file.shown, srdf=srdf), robot):
                    yield file.shown

    def _prefixes_of(self, robot: Robot) -> tuple[str, str]:
        """Return what stands before its joints only where the controller names them, or only here.

        A launch file that is not here gives xacro another prefix.
        """
        names = tuple(joint.name for joint in robot.arm_joints)
        if self._spoken.among(set(names)):
            return "", ""
        prefix = prefix_before(names, self._spoken.words)
        return prefix, "" if prefix else prefix_left_out(names, self._spoken.joints)

    def _skip(self, file: DescriptionFile, reason: str, *, is_meant: bool = False) -> None:
        self._skipped.append(f"{file.shown}: {reason}")
        if is_meant and not self._ranks.is_of_tests(file):
            self._unreadable.append(self._skipped[-1])
