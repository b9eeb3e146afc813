"""Gather what speaks for each robot that a controller may drive, as far as it decides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice
from tracerisk.pipeline.launch.robots_launched import launched_robots
from tracerisk.pipeline.robot.evidence import (
    CLEAR,
    DESCRIBED,
    DRIVER,
    JOINTS,
    LAUNCHED,
    LEAST,
    NAMES,
    NEAR,
    ONLY,
    Evidence,
    is_decided,
)
from tracerisk.pipeline.robot.hints import folders_around, robot_hints, source_hints
from tracerisk.pipeline.robot.installed_descriptions import installed_descriptions
from tracerisk.pipeline.robot.named_parts import (
    Parts,
    described_parts,
    evidence_of_names,
    evidence_of_parts,
    shipped_parts,
)
from tracerisk.pipeline.robot.speech import Speech, own_speeches, speeches_beside, strings_of
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.driver_files import driver_files
from tracerisk.pipeline.workspace.own_modules import with_own_modules
from tracerisk.pipeline.workspace.package_folders import imported_names
from tracerisk.pipeline.workspace.workspace import named_packages, workspace_of
from tracerisk.ros.vendors.driver_search import read_drivers, shipped_drivers
from tracerisk.twin.robots.generic import is_finger_name
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.names_in_source import LaunchedDescription, Spoken
from tracerisk.twin.robots.prefix import prefix_in
from tracerisk.twin.robots.robot_names import Hint, another_arm, mentioned
from tracerisk.twin.workspace.described_robots import DescribedRobot, WorkspaceRobots
from tracerisk.twin.workspace.robot_of_workspace import find_workspace_robots


@dataclass(frozen=True, slots=True)
class Gathered:
    """What speaks for robots."""

    evidence: tuple[Evidence, ...]
    """All of it."""
    found: WorkspaceRobots
    """The robots of the workspace."""
    prefix: str
    """What is before all joints of a shipped arm where the controller names them."""


class Gathering:
    """What speaks for robots, gathered from the strongest on until it is decided."""

    def __init__(
        self,
        controller: Controller,
        settings: Settings,
        launch: LaunchChoice,
        also_named: tuple[str, ...],
    ) -> None:
        self._controller = controller
        self._settings = settings
        self._launch = launch
        self.workspace = workspace_of(controller, settings)
        self.whole = with_own_modules(controller)
        self.speeches = own_speeches(controller, also_named)
        self.shipped = {shipped_name.name: shipped_name for shipped_name in shipped_names()}

    @cached_property
    def _beside(self) -> tuple[Speech, ...]:
        return tuple(speeches_beside(self._controller))

    @property
    def beside_read(self) -> tuple[Speech, ...]:
        """The programs beside it, where they have been asked."""
        return self._beside if "_beside" in vars(self) else ()

    def spoken(self, speeches: Sequence[Speech]) -> Spoken:
        """Return what sources say about the robot of the workspace."""
        return self._said(speeches)[0]

    def _said(self, speeches: Sequence[Speech]) -> tuple[Spoken, Mapping[str, Path]]:
        """Return what sources say, and the installed packages in which they mean a robot."""
        own, root, strings = self.speeches[0], self._controller.root, strings_of(speeches)
        source = self.whole.source
        described = installed_descriptions(root, self.workspace, strings, source)
        named = named_packages(root, self.workspace.packages, strings) | described.keys()
        around = " ".join(folders_around(self._controller))
        spoken = Spoken(strings, named, self._launched, own.listed, own.strings, around)
        return spoken, described

    @cached_property
    def _launched(self) -> tuple[LaunchedDescription, ...]:
        """The robots of launch files; to read those of ROS 2 costs a process each."""
        strings = strings_of(self.speeches)
        return launched_robots(self._controller, self._settings, self._launch, strings)

    def _workspace(self, speeches: Sequence[Speech]) -> WorkspaceRobots:
        root, workspace = self._controller.root, self.workspace
        spoken, described = self._said(speeches)
        return find_workspace_robots(
            (root, *workspace.packages.values(), *described.values()),
            workspace.findable,
            spoken,
            self._controller.path,
            self._settings.limits,
        )

    def gathered(self) -> Gathered:
        """Return what speaks for robots, as much of it as changes which one is taken."""
        workspace = self._workspace(self.speeches)
        robots = [
            described_parts(described_robot.key, described_robot.robot)
            for described_robot in workspace.described
        ]
        plain = [shipped_parts(robot_names) for robot_names in self.shipped.values()]
        speeches, prefix = self.speeches, ""
        if not any(_says_joints(plain, speech) for speech in speeches):
            words = frozenset[str]().union(*(speech.words for speech in speeches))
            prefix = prefix_in(words, self.shipped.values())
        evidence: list[Evidence] = []
        for speech in speeches:
            evidence += evidence_of_parts([*robots, *plain], speech)
            if prefix:
                evidence += evidence_of_parts(plain, speech.without(prefix))
        for one in workspace.described:
            evidence += self._of_description(one, evidence, is_only=len(robots) == 1)
        if prefix:
            # Without it the joints that the controller lists are none of a shipped arm's.
            evidence = [one for one in evidence if one.points > 0 or one.robot not in self.shipped]
        evidence += self._of_other_arms()
        fitting = self._fitting(evidence)
        own = _copies(robots, plain)
        for hint in robot_hints(self._controller):
            if NAMES[hint.what] < CLEAR and is_decided(evidence):
                break
            if hint.what == "a program beside it" and self._beside:
                workspace, more = self._with_theirs(workspace, evidence)
                robots = [
                    described_parts(described_robot.key, described_robot.robot)
                    for described_robot in workspace.described
                ]
                said = self._of_programs_beside([*robots, *plain])
                if said is None:
                    continue
                evidence += [*more, *said]
            if self._settings.launch is False and hint.what == "a launch file":
                continue
            said = list(evidence_of_names(hint, self.shipped, fitting))
            evidence += said
            evidence += [replace(one, robot=key) for one in said for key in own.get(one.robot, ())]
        evidence += [] if is_decided(evidence) else self._of_driver()
        evidence += self._of_likeness(workspace)
        return Gathered(tuple(evidence), workspace, prefix)

    def _fitting(self, evidence: Sequence[Evidence]) -> frozenset[str]:
        """Return the shipped robots of which a name may speak: those against which nothing does."""
        against = {one.robot for one in evidence if one.points < 0}
        return frozenset(self.shipped) - against

    def _of_other_arms(self) -> Iterator[Evidence]:
        """Yield what speaks against shipped robots: the source names another arm of their maker."""
        own = self._controller
        text = f"{own.path.name} {own.source.decode(errors='replace')}"
        for name in self.shipped:
            other = another_arm(text, name)
            if other is not None:
                words = f"its source names another arm, {other}"
                yield Evidence(name, words, own.path.name, None, -JOINTS, "name")

    def _of_description(
        self, found: DescribedRobot, named: Sequence[Evidence], *, is_only: bool
    ) -> Iterator[Evidence]:
        """Yield what speaks for a robot by where its description is, and who names that."""
        key = found.key
        if found.launched_by is not None and found.launched_by in LAUNCHED:
            words = "a launch file describes the robot by it"
            points = LAUNCHED[found.launched_by]
            yield Evidence(key, words, found.launch_file, None, points)
        is_named = any(one.robot == key and one.points > 0 for one in named)
        is_meant = is_named or found.launched_by == "controller"
        if found.launched_by != "controller" and self._is_of_another(found):
            if is_meant and not found.is_only:
                models = ", ".join(sorted(self._models_meant))
                words = f"the controller is for {models}, by its source or its folder"
                yield Evidence(key, words, self.speeches[0].file, None, -JOINTS, "name")
            if not is_meant or not found.is_only:
                return
        if is_meant or found.is_called:
            yield Evidence(key, "the workspace describes what is named", key, None, DESCRIBED)
        if found.is_called:
            words = "the robot is named by its own name"
            yield Evidence(key, words, self.speeches[0].file, None, NAMES["its source"], "name")
        if found.is_near:
            words = "its package is the controller's, or one that it names"
            yield Evidence(key, words, key, None, NEAR)
        if found.is_only and is_only:
            yield Evidence(key, "the workspace describes no other robot", key, None, ONLY)

    def _is_of_another(self, found: DescribedRobot) -> bool:
        """Return whether a robot has the name of a shipped one, and the controller another's.

        A gripper alone is another than any arm that the controller names.
        """
        if not found.robot.arm_joints and self._named_in_source:
            return True
        called = mentioned(f"{found.key} {found.robot.name}", self.shipped)
        return bool(called and self._models_meant) and called.isdisjoint(self._models_meant)

    @cached_property
    def _models_meant(self) -> frozenset[str]:
        """The shipped robots that the source names; of several, those that folders name too."""
        around = mentioned(" ".join(folders_around(self._controller)), self.shipped)
        own = self._named_in_source
        return own & around or own or around

    @cached_property
    def _named_in_source(self) -> frozenset[str]:
        """The shipped robots that the controller's imports and own source name."""
        hints = source_hints(self._controller)
        texts = (text for hint in hints for text in hint.texts.values())
        return frozenset[str]().union(*(mentioned(text, self.shipped) for text in texts))

    def _with_theirs(
        self, found: WorkspaceRobots, evidence: Sequence[Evidence]
    ) -> tuple[WorkspaceRobots, list[Evidence]]:
        """Return the robots of the workspace with those that programs of the folder name.

        The other value is what speaks for these. Where the controller itself names a part of one
        of its own, they are not searched for.
        """
        keys = {described_robot.key for described_robot in found.described}
        if any(one.robot in keys and one.points > DESCRIBED for one in evidence):
            return found, []
        theirs = self._workspace((*self.speeches, *self._beside))
        more = tuple(
            described_robot
            for described_robot in theirs.described
            if described_robot.key not in keys
        )
        skipped = tuple(dict.fromkeys((*found.skipped, *theirs.skipped)))
        unreadable = tuple(dict.fromkeys((*found.unreadable, *theirs.unreadable)))
        both = WorkspaceRobots((*found.described, *more), skipped, unreadable)
        parts = [
            described_parts(described_robot.key, described_robot.robot) for described_robot in more
        ]
        said = [one for speech in self._beside for one in evidence_of_parts(parts, speech)]
        own = [one for speech in self.speeches for one in evidence_of_parts(parts, speech)]
        for described_robot in more:
            own += self._of_description(described_robot, said, is_only=len(both.described) == 1)
        return both, own

    def _of_programs_beside(self, robots: Sequence[Parts]) -> list[Evidence] | None:
        """Return what the other programs of the folder say; together they count as one.

        `None` where they drive several robots: then none of these is meant.
        """
        said = [tuple(evidence_of_parts(robots, speech)) for speech in self._beside]
        spoken = [[one for one in evidences if one.points > LEAST] for evidences in said]
        speaking = [{one.robot for one in evidences} for evidences in spoken if evidences]
        if speaking and not frozenset.intersection(*map(frozenset, speaking)):
            return None
        return [
            replace(one, points=one.points / len(speaking))
            for evidences in spoken
            for one in evidences
        ]

    def _of_driver(self) -> Iterator[Evidence]:
        """Yield what the one driver says whose messages the controller imports."""
        imported = imported_names(self.whole.source.decode(errors="replace"))
        project = self._controller.project
        drivers = read_drivers(driver_files(project, self._settings), project.root)
        table = {
            shipped_driver.robot: shipped_driver
            for shipped_driver in (*shipped_drivers(), *drivers)
            if shipped_driver.robot is not None and imported & set(shipped_driver.packages)
        }
        for name, driver in table.items() if len(table) == 1 else ():
            assert name is not None
            words = f"{name} is what driver {driver.name} is for"
            yield Evidence(name, words, driver.file, None, DRIVER, "driver")

    def _of_likeness(self, found: WorkspaceRobots) -> Iterator[Evidence]:
        """Yield, for shipped robots with the joints of an SRDF, what its names say."""
        for one in found.described:
            if one.srdf is not None and len(one.like) > 1:
                # Makers call many of them alike: the package says which arm it is of.
                around = " ".join(folder.name for folder in list(one.files[0].parents)[:2])
                hint = Hint("the SRDF", {one.key: f"{one.srdf.name} {one.key} {around}"})
                yield from evidence_of_names(hint, self.shipped, one.like)


def _copies(described: Sequence[Parts], shipped: Sequence[Parts]) -> dict[str, list[str]]:
    """Return the descriptions that are of a shipped robot by joints that no other one has.

    A name of that robot is as much the description's, which may have other groups. The gripper
    may be another one.
    """
    copies: dict[str, list[str]] = {}
    arms = {
        one.key: {joint for joint in one.joints if not is_finger_name(joint)} for one in shipped
    }
    for parts in described:
        like = [name for name, joints in arms.items() if joints and joints <= parts.joints]
        if len(like) == 1:
            copies.setdefault(like[0], []).append(parts.key)
    return copies


def _says_joints(robots: Sequence[Parts], speech: Speech) -> bool:
    return any(one.points >= DRIVER * speech.share for one in evidence_of_parts(robots, speech))
