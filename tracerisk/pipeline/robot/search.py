"""Weigh what speaks for each robot that a controller may drive, where settings name none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tracerisk.config import Settings
from tracerisk.pipeline.launch.choose import LaunchChoice
from tracerisk.pipeline.robot.choice import (
    RobotChoice,
    equipped,
    with_groups_asked,
    with_groups_of,
)
from tracerisk.pipeline.robot.evidence import (
    DESCRIBED,
    DRIVER,
    LEAST,
    Ranking,
    ranked,
    shown,
    weighed,
)
from tracerisk.pipeline.robot.gathering import Gathered, Gathering
from tracerisk.pipeline.robot.hints import folders_around
from tracerisk.pipeline.robot.installed_descriptions import installed_in
from tracerisk.pipeline.robot.speech import groups_asked_of, states_asked_of, strings_of
from tracerisk.pipeline.workspace.controller import Controller, string_literals
from tracerisk.pipeline.workspace.own_modules import with_own_modules
from tracerisk.twin.robots.generic import NamesAsked, generic_arm, names_asked
from tracerisk.twin.robots.names_in_source import Spoken
from tracerisk.twin.robots.prefix import with_numbered, with_prefix
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_names import another_number, is_number, mentioned
from tracerisk.twin.workspace.described_robots import (
    DescribedRobot,
)
from tracerisk.twin.workspace.srdf_pairing import shipped_with_srdf
from tracerisk.twin.workspace.srdf_stand_in import spoken_srdf, srdf_stand_in

# Of arms that are called alike the one that most public programs drive.
_USUAL = (
    *("ur5e", "panda", "ur5", "ur10e", "ur10", "gen3", "iiwa7", "iiwa7_stack", "m1013"),
    *("wx250s", "wx200", "px100"),
)
_MOST_SHOWN = 6


def searched_robot(
    controller: Controller,
    settings: Settings,
    launch: LaunchChoice,
    also_named: tuple[str, ...] = (),
) -> RobotChoice:
    """Return the robot for which most speaks; its `chosen_by` says what.

    A tie, little evidence, and a description that cannot be read make it an assumption, its
    `doubt`. Where little speaks for any, it is a generic arm, with the names of the workspace's
    SRDF where that is all there is. `also_named` are joints that the controller names in its run,
    and not in its source.
    """
    return _Search(controller, settings, launch, also_named).run()


def stand_in(controller: Controller, chosen_by: str) -> RobotChoice:
    """Return a generic robot: with the parts of the workspace's SRDF that the controller names.

    Where no SRDF has any, it is an arm with the joints that the controller names.
    """
    whole = with_own_modules(controller)
    asked = names_asked(whole.tree)
    spoken = Spoken((*string_literals(controller), *string_literals(whole)))
    return _generic(controller, whole, spoken, asked, chosen_by)


def _generic(
    controller: Controller, whole: Controller, spoken: Spoken, asked: NamesAsked, chosen_by: str
) -> RobotChoice:
    packages = controller.workspace.packages
    pair = spoken_srdf((controller.root, *packages.values()), spoken, controller.path)
    robot = None if pair is None else srdf_stand_in(pair[0], asked)
    if pair is None or robot is None:
        return RobotChoice(replace(generic_arm(asked), chosen_by=chosen_by))
    origin = f"{chosen_by}, with the names of {pair[0].file}"
    return RobotChoice(equipped(replace(robot, chosen_by=origin), whole), files=(pair[1],))


class _Search:
    def __init__(
        self,
        controller: Controller,
        settings: Settings,
        launch: LaunchChoice,
        also_named: tuple[str, ...],
    ) -> None:
        self._controller = controller
        self._gathering = Gathering(controller, settings, launch, also_named)
        self._whole = self._gathering.whole
        self._speeches = self._gathering.speeches
        self._shipped = self._gathering.shipped
        asked = names_asked(self._whole.tree)
        self._asked = replace(asked, joints=tuple(dict.fromkeys((*also_named, *asked.joints))))

    def run(self) -> RobotChoice:
        gathered = self._gathering.gathered()
        known = (described_robot.key for described_robot in gathered.found.described)
        ranking = ranked(gathered.evidence, (*known, *_USUAL))
        choice = self._taken(gathered, ranking)
        if ranking.best:
            line = weighed(gathered.evidence, ranking.best, choice.robot.chosen_by)
            choice = replace(choice, robot=replace(choice.robot, weighed=line))
        return replace(choice, skipped=gathered.found.skipped, evidence=shown(gathered.evidence))

    def _taken(self, gathered: Gathered, ranking: Ranking) -> RobotChoice:
        """Return the robot that the ranking means, with its doubts."""
        workspace_robots = gathered.found
        described = {
            described_robot.key: described_robot for described_robot in workspace_robots.described
        }
        best = described.get(ranking.best)
        if best is not None and not self._is_any_arm(best, gathered):
            return self._of_workspace(best, gathered, ranking)
        if best is not None:
            reason = f"{best.key}: no URDF or known robot has its joints"
            return self._unknown(ranking, (*workspace_robots.unreadable, reason))
        if not ranking.best:
            return self._unknown(ranking, workspace_robots.unreadable)
        if workspace_robots.unreadable and not self._is_that(ranking.best, gathered):
            return self._unknown(ranking, workspace_robots.unreadable)
        robot = self._shipped_robot(ranking.best, gathered)
        doubts = [*_doubts(ranking, gathered), *self._contradictions(ranking.best, gathered)]
        if workspace_robots.unreadable and not (
            ranking.is_sure and self._names_joints(gathered, ranking)
        ):
            doubts.append(
                f"that of the workspace cannot be read: {_listed(workspace_robots.unreadable)}"
            )
        return RobotChoice(equipped(_doubted(robot, doubts), self._whole))

    def _contradictions(self, name: str, gathered: Gathered) -> Iterator[str]:
        """Yield which other robots the workspace speaks of, though a source names a shipped one.

        What a program was copied from stays in its topics and defaults; its folders are named for
        what it drives, and what is described beside it is driven by somebody.
        """
        against = {one.robot for one in gathered.evidence if one.points < 0 and one.kind != "name"}
        folders = " ".join((*folders_around(self._controller), self._controller.path.stem))
        around = mentioned(folders, self._shipped)
        others = sorted(around - against)
        if name not in around and others:
            yield f"its folders name {', '.join(others)}, not {name}; name it with --robot"
        elif not around and (other := another_number(f"{folders} {self._text}", name)):
            yield f"its folders or source name {other}, not {name}; name it with --robot"
        spoken = {one.robot for one in gathered.evidence if one.points > 0}
        for found in gathered.found.described:
            key = found.key
            called = mentioned(f"{key} {found.robot.name}", self._shipped)
            if called and name not in called and key in spoken - against:
                yield f"the workspace describes another, {key}; name it with --robot {key}"

    @property
    def _text(self) -> str:
        return self._controller.source.decode(errors="replace")

    def _is_that(self, name: str, gathered: Gathered) -> bool:
        """Return whether a shipped robot may be the one of files that cannot be read.

        Its joints are named, or these files have its name.
        """
        own = (one for one in gathered.evidence if one.robot == name)
        if any(one.kind == "joints" and one.points > DRIVER for one in own):
            return True
        return any(name in mentioned(text, self._shipped) for text in gathered.found.unreadable)

    def _names_joints(self, gathered: Gathered, ranking: Ranking) -> bool:
        return any(
            one.robot == ranking.best and one.kind == "joints" and one.points >= DESCRIBED
            for one in gathered.evidence
        )

    def _shipped_robot(self, name: str, gathered: Gathered) -> Robot:
        states = states_asked_of(self._speeches)
        robot = with_groups_of(load_robot(name), strings_of(self._speeches), states)
        robot = with_groups_asked(robot, groups_asked_of(self._speeches))
        reason = _reason(name, gathered)
        if gathered.prefix:
            robot = with_prefix(robot, gathered.prefix)
            reason = f"{reason}; its links and joints have the prefix '{gathered.prefix}'"
        listed = tuple(dict.fromkeys(joint for speech in self._speeches for joint in speech.listed))
        numbered = with_numbered(robot, listed)
        if numbered is not None:
            words = (
                f"its joints are called {listed[0]} to {listed[-1]}, as the controller lists them"
            )
            robot = _doubted(numbered, [*([robot.doubt] if robot.doubt else []), words])
        return replace(robot, chosen_by=reason)

    def _is_any_arm(self, found: DescribedRobot, gathered: Gathered) -> bool:
        """Return whether an SRDF without its URDF only counts its joints, and names no arm."""
        if found.srdf is None or any(one.robot in found.like for one in gathered.evidence):
            return False
        return all(is_number(joint.name) for joint in found.robot.arm_joints)

    def _of_workspace(
        self, found: DescribedRobot, gathered: Gathered, ranking: Ranking
    ) -> RobotChoice:
        robot, reason, doubts = found.robot, found.reason, [*_doubts(ranking, gathered)]
        own = {speech.file for speech in self._speeches}
        said = {one.file for one in gathered.evidence if one.robot == found.key and one.points > 0}
        if said & {speech.file for speech in self._gathering.beside_read} and not said & own:
            reason = f"{reason}, as programs beside it do"
        if found.srdf is not None:
            likeness = [one for one in gathered.evidence if one.robot in found.like]
            like = ranked(likeness, _USUAL)
            best = like.best or next((name for name in _USUAL if name in found.like), found.like[0])
            if best != found.like[0]:
                robot = shipped_with_srdf(best, found.prefix, found.srdf)
            reason = f"{reason}, the arm from {best}"
            if len(found.like) > 1 and (like.rivals or not like.best):
                others = ", ".join(name for name in found.like if name != best)
                doubts.append(f"{found.key} has the joints of {others} as well as of {best}")
        if robot.doubt:
            doubts.append(robot.doubt)
        arms = {one.robot for one in gathered.evidence if one.points > LEAST} & self._shipped.keys()
        if arms and not robot.arm_joints:
            named = ", ".join(sorted(arms)[:_MOST_SHOWN])
            doubts.append(f"{found.key} is a gripper alone, which may be on an arm: {named}")
        reason = f"{reason}{installed_in(found.files, self._gathering.workspace.prefixes)}"
        robot = _doubted(replace(robot, chosen_by=reason), doubts)
        robot = with_groups_asked(robot, groups_asked_of(self._speeches))
        return RobotChoice(equipped(robot, self._whole), files=found.files)

    def _unknown(self, ranking: Ranking, unreadable: Sequence[str]) -> RobotChoice:
        """Return a generic robot, with what is known of the robot in its place."""
        reason = "a stand-in for the robot, which is not known: name it with --robot"
        if unreadable:
            reason = (
                f"a stand-in for the robot of the workspace, which cannot be read "
                f"({_listed(unreadable)}): put what is missing into the workspace, mend the file, "
                "or name the robot with --robot"
            )
            spoken = self._gathering.spoken(self._speeches)
            return _generic(self._controller, self._whole, spoken, self._asked, reason)
        if ranking.rivals:
            reason = f"{reason}; as much speaks for {', '.join(ranking.rivals)}"
        robot = replace(generic_arm(self._asked), chosen_by=reason)
        return RobotChoice(equipped(robot, self._whole))


def _reason(robot: str, gathered: Gathered) -> str:
    """Return the strongest of what speaks for a robot: its parts first, then its name."""
    own = [one for one in gathered.evidence if one.robot == robot and one.points > 0]
    own.sort(key=lambda one: -one.points)
    parts = [one for one in own if one.kind != "name"][:1]
    names = [one for one in own if one.kind == "name"][:1]
    return "; ".join(f"{one.words} ({one.file})" for one in (*parts, *names))


def _doubts(ranking: Ranking, gathered: Gathered) -> Iterator[str]:
    """Yield why the robot of a ranking is an assumption."""
    keys = {described_robot.key for described_robot in gathered.found.described}
    if ranking.rivals:
        others = ", ".join(ranking.rivals[:_MOST_SHOWN])
        where = " in the workspace" if keys.issuperset(ranking.rivals) else ""
        yield f"{others}{where} would fit as well; name it with --robot"
    elif not ranking.is_sure:
        yield f"all that speaks for it is that {_reason(ranking.best, gathered)}"


def _doubted(robot: Robot, doubts: Sequence[str]) -> Robot:
    known = tuple(dict.fromkeys(doubts))
    if not known:
        return robot
    return replace(robot, doubt="; ".join(known), assumes_names=True)


def _listed(reasons: Sequence[str]) -> str:
    return "; ".join(dict.fromkeys(reasons))
