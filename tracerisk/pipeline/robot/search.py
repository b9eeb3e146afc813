"""Which robot a controller drives that the settings do not name."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tracerisk.config import Settings
from tracerisk.errors import RobotError
from tracerisk.pipeline.launch.choose import LaunchChoice
from tracerisk.pipeline.launch.robots_launched import launched_robots
from tracerisk.pipeline.robot.choice import RobotChoice, equipped
from tracerisk.pipeline.robot.hints import robot_hints
from tracerisk.pipeline.robot.installed_descriptions import installed_descriptions, installed_in
from tracerisk.pipeline.workspace.controller import Controller, string_literals
from tracerisk.pipeline.workspace.driver_files import driver_files
from tracerisk.pipeline.workspace.own_modules import with_own_modules
from tracerisk.pipeline.workspace.prefixes import Prefix
from tracerisk.pipeline.workspace.sibling_programs import sibling_programs
from tracerisk.pipeline.workspace.workspace import (
    find_workspace,
    imported_names,
    named_packages,
    workspace_of,
)
from tracerisk.twin.robots.detect import NoRobotNamedError, SeveralRobotsError, detect_robot
from tracerisk.twin.robots.generic import NamesAsked, generic_arm, names_asked
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.names_in_source import Spoken
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_names import decide, mentioned
from tracerisk.twin.workspace.robot_of_workspace import (
    UnreadableRobotError,
    WorkspaceRobot,
    find_workspace_robot,
)
from tracerisk.twin.workspace.srdf_stand_in import spoken_srdf, srdf_stand_in
from tracerisk.vendors.driver_search import read_drivers, shipped_drivers


@dataclass(frozen=True, slots=True)
class _Asked:
    """What a controller names: `whole` is it with its own modules, `listed` its own joints."""

    whole: Controller
    strings: tuple[str, ...]
    names: NamesAsked
    listed: tuple[str, ...]

    @classmethod
    def by(cls, controller: Controller, also_named: tuple[str, ...] = ()) -> _Asked:
        """Return what a controller and its own modules name, and joints that are named besides."""
        whole = with_own_modules(controller)
        strings = (*string_literals(controller), *string_literals(whole), *also_named)
        names = names_asked(whole.source)
        joints = tuple(dict.fromkeys((*also_named, *names.joints)))
        # Modules are written for more than one robot.
        listed = tuple(dict.fromkeys((*also_named, *names_asked(controller.source).joints)))
        return cls(whole, strings, replace(names, joints=joints), listed)


def searched_robot(
    controller: Controller,
    settings: Settings,
    launch: LaunchChoice,
    also_named: tuple[str, ...] = (),
) -> RobotChoice:
    """Return the robot that a controller drives; its `chosen_by` says why it is this one.

    The first that applies: the one of its workspace, if the controller names a part of it or its
    launch file describes it; the shipped one whose parts it names; that of the programs beside it;
    the shipped one that is named, and nothing else of it; the only one of its workspace; a generic
    arm. `also_named` are joints that it names in its run, and not in its source.
    Raises RobotError where several fit equally well, or that of the workspace cannot be read.
    """
    return _Search(controller, settings, launch, also_named).run()


def stand_in(controller: Controller, chosen_by: str) -> RobotChoice:
    """Return a generic robot: with the parts of the workspace's SRDF that the controller names.

    Where no SRDF has any, it is an arm with the joints that the controller names.
    """
    asked = _Asked.by(controller)
    packages = find_workspace(controller.root).packages
    spoken = Spoken(asked.strings, joints=asked.listed)
    found = spoken_srdf((controller.root, *packages.values()), spoken, controller.path)
    robot = None if found is None else srdf_stand_in(found[0], asked.names)
    if found is None or robot is None:
        return RobotChoice(replace(generic_arm(asked.names), chosen_by=chosen_by))
    origin = f"{chosen_by}, with the names of {found[0].file}"
    return RobotChoice(equipped(replace(robot, chosen_by=origin), asked.whole), files=(found[1],))


# What these say of the robot has been weighed in other ways.
_ASKED_BEFORE = frozenset({"a program beside it", "the package's manifest"})


class _Search:
    def __init__(
        self,
        controller: Controller,
        settings: Settings,
        launch: LaunchChoice,
        also_named: tuple[str, ...],
    ) -> None:
        self._controller = controller
        self._settings = settings
        self._asked = _Asked.by(controller, also_named)
        self._prefixes: tuple[Prefix, ...] = ()
        self._launched = launched_robots(controller, settings, launch, self._asked.strings)
        self._found = self._in_workspace(self._asked.strings)
        self._unreadable = self._found.unreadable

    def run(self) -> RobotChoice:
        found = self._found
        if found.robot is not None and found.is_named:
            return self._of_workspace(found)
        refused: SeveralRobotsError | None = None
        try:
            return self._shipped(self._detected(self._asked, by_parts=True))
        except NoRobotNamedError:
            pass
        except SeveralRobotsError as error:
            refused = error
        beside = self._of_siblings() if refused is None else None
        if beside is not None:
            return beside
        if refused is None:
            try:
                robot = self._detected(self._asked, by_parts=False)
            except RobotError:
                pass
            else:
                if self._may_be(robot):
                    return self._shipped(robot)
        if found.robot is not None:
            return self._of_workspace(found)
        if refused is not None:
            raise refused
        if self._unreadable:
            text = "; ".join(dict.fromkeys(self._unreadable))
            # Another arm in its place would give figures of a robot that is not there.
            raise UnreadableRobotError(
                f"the robot of the workspace cannot be read: {text}"
                "; put what is missing into the workspace, mend the file, or say with --robot "
                "which robot it is: a file, a shipped one, or generic for a stand-in"
            )
        generic = replace(
            generic_arm(self._asked.names),
            chosen_by="a stand-in for the robot, which is not known: name it with --robot",
        )
        return self._shipped(self._of_driver() or self._spoken_of() or generic)

    def _in_workspace(self, strings: tuple[str, ...]) -> WorkspaceRobot:
        root = self._controller.root
        workspace = workspace_of(self._controller, self._settings)
        self._prefixes = workspace.prefixes
        described = installed_descriptions(root, workspace, strings)
        packages = workspace.findable
        named = named_packages(root, workspace.packages, strings) | described.keys()
        own = string_literals(self._controller)
        spoken = Spoken(strings, named, self._launched, self._asked.listed, own)
        roots = (root, *workspace.packages.values(), *described.values())
        return find_workspace_robot(
            roots, packages, spoken, self._controller.path, self._settings.limits
        )

    def _detected(self, asked: _Asked, *, by_parts: bool) -> Robot:
        hints = robot_hints(self._controller)
        return detect_robot(asked.strings, hints, asked.names.joints, by_parts=by_parts)

    def _of_siblings(self) -> RobotChoice | None:
        """Return the one robot that the programs beside the controller name, `None` for none."""
        siblings = sibling_programs(self._controller)
        if not siblings:
            return None
        strings = tuple(text for each in siblings for text in string_literals(each))
        theirs = self._in_workspace((*self._asked.strings, *strings))
        self._unreadable += theirs.unreadable
        if theirs.robot is not None and theirs.is_named and not self._names_another(theirs.robot):
            taken = self._of_workspace(theirs)
            origin = f"{taken.robot.chosen_by}, as programs beside it do"
            return replace(taken, robot=replace(taken.robot, chosen_by=origin))
        found: dict[str, tuple[Robot, str]] = {}
        others: set[str] = set()
        for each in siblings:
            try:
                robot = detect_robot(string_literals(each), by_parts=True)
            except SeveralRobotsError as error:
                others |= set(error.names)
            except RobotError:
                continue
            else:
                found.setdefault(robot.name, (robot, each.path.name))
        if len(found) != 1 or (others and not others & found.keys()):
            return None
        robot, file = next(iter(found.values()))
        if self._names_another(robot) or not set(self._asked.names.joints) <= {
            joint.name for joint in robot.joints
        }:
            return None
        origin = f"{robot.name} is inferred from the names in {file} beside it"
        return self._shipped(replace(robot, chosen_by=origin, assumes_names=True))

    def _of_driver(self) -> Robot | None:
        """Return the robot of the one driver whose messages the controller imports."""
        imported = imported_names(self._asked.whole.source.decode(errors="replace"))
        drivers = read_drivers(
            driver_files(self._controller.root, self._settings), self._controller.root
        )
        found = {
            each.robot: each
            for each in (*shipped_drivers(), *drivers)
            if each.robot is not None and imported & set(each.packages)
        }
        if len(found) != 1:
            return None
        ((name, driver),) = found.items()
        assert name is not None
        doubt = f"nothing names it but that it is what driver {driver.name} is for"
        reason = f"{name} is what driver {driver.name} ({driver.file}) is for"
        return replace(load_robot(name), chosen_by=reason, assumes_names=True, doubt=doubt)

    def _spoken_of(self) -> Robot | None:
        """Return the shipped robot that comments, launch files or a readme alone speak of."""
        known = {each.name: each for each in shipped_names()}
        unasked = {*_ASKED_BEFORE, *(() if self._settings.launch else ("a launch file",))}
        hints = (each for each in robot_hints(self._controller) if each.what not in unasked)
        verdict = decide(known, known, hints)
        if not verdict.reason:
            return None
        robot = load_robot(verdict.left[0])
        names = self._asked.names
        if not set(names.joints) <= {joint.name for joint in robot.joints}:
            return None
        doubt = f"nothing names it but that {verdict.reason}"
        return replace(robot, chosen_by=verdict.reason, assumes_names=True, doubt=doubt)

    def _names_another(self, robot: Robot) -> bool:
        """Return whether the controller itself names a robot, and not this one."""
        known = {each.name: each for each in shipped_names()}
        hint = next(robot_hints(self._controller))
        text = "\n".join(hint.texts.values())
        named = mentioned(text, known)
        own = mentioned(robot.name, known)
        return bool(named) and not named & own

    def _may_be(self, robot: Robot) -> bool:
        """Return whether a robot of which only the name is named may be the one of the workspace.

        Where that cannot be read, it is another one unless the files of it bear the name too.
        """
        known = {each.name: each for each in shipped_names()}
        unreadable = self._unreadable
        return not unreadable or any(robot.name in mentioned(each, known) for each in unreadable)

    def _shipped(self, robot: Robot) -> RobotChoice:
        return RobotChoice(equipped(robot, self._asked.whole), self._found.skipped)

    def _of_workspace(self, found: WorkspaceRobot) -> RobotChoice:
        assert found.robot is not None
        reason = f"{found.reason}{installed_in(found.files, self._prefixes)}"
        robot = equipped(replace(found.robot, chosen_by=reason), self._asked.whole)
        return RobotChoice(robot, found.skipped, found.files)
