"""Find the robot that a controller speaks of, from the strings in its source."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.robots.index import RobotNames, shipped_names
from tracerisk.twin.robots.prefix import prefix_in, with_prefix
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_names import EVERYDAY, Hint, decide, is_number, is_plain, words_in

_SHORTEST_STEM = 5  # `joint` alone says nothing about the arm
_HALF = 0.5  # the share of an arm's joints that must be named where their names are plain
_FEWEST = 3


class NoRobotNamedError(RobotError):
    """The controller's strings speak of no known robot."""


class SeveralRobotsError(RobotError):
    """The controller's strings fit several robots, and nothing says which one is meant."""

    names: tuple[str, ...] = ()
    """The robots that they fit."""


@dataclass(frozen=True, slots=True)
class _Fit:
    """How a robot fits the words of a controller.

    `joints` and `places` are the joints, and the links, groups and controllers, that are named.
    `is_certain` says that they can be meant as this robot's, and not as any arm's.
    """

    joints: frozenset[str]
    places: frozenset[str]
    is_named: bool
    is_certain: bool
    is_whole: bool

    @property
    def rank(self) -> tuple[int, int]:
        return len(self.joints), sum(1 for name in self.places if not is_plain(name))

    @property
    def says_anything(self) -> bool:
        return bool(self.joints or self.places or self.is_named)


def detect_robot(
    strings: Iterable[str],
    hints: Iterable[Hint] = (),
    listed: Collection[str] = (),
    *,
    by_parts: bool = False,
) -> Robot:
    """Return the robot whose joints, links or groups the strings name; `chosen_by` says how.

    A string counts as a whole, as a part of a ROS name (`/panda_arm_controller/command`), as the
    stem of numbered names (`panda_joint`), or behind another one (`panda_`, `joint1`). Joints speak
    louder than links and groups, and these louder than the robot's own name. Names that any arm
    could have (`elbow_joint`) count where half of an arm's joints are named. Of several robots that
    fit equally the hints decide, else the only one whose joints are all named. Where only numbers
    (`joint1`) or plain names fit, or none at all, a robot is taken only if a hint names it and it
    has the joints that are `listed` as such. Where no robot fits, one does whose joints are all
    named with a prefix, and has it before the names of its links and joints. Groups that a robot
    lacks are assumed where none of its own is named. `by_parts` takes no robot of which nothing
    but its name is named.

    Raises NoRobotNamedError when no robot fits, SeveralRobotsError when several do.
    """
    given = tuple(strings)
    robots = {each.name: each for each in shipped_names()}
    weighed = _Once(hints)
    try:
        return _assuming_groups(_detect(given, robots, weighed, listed, by_parts), given)
    except NoRobotNamedError:
        prefix = prefix_in(words_in(given), robots.values())
        if not prefix:
            raise
    bare = [word.removeprefix(prefix) for word in words_in(given)]
    plain = [name.removeprefix(prefix) for name in listed]
    robot = _detect(bare, robots, weighed, plain, by_parts)
    origin = f"{robot.chosen_by}; its links and joints have the prefix '{prefix}'"
    return replace(with_prefix(robot, prefix), chosen_by=origin)


def _assuming_groups(robot: Robot, strings: Iterable[str]) -> Robot:
    """Return a robot that assumes the groups it lacks where the strings name none that it has.

    Whoever wrote such a program has a configuration of MoveIt whose groups have other names.
    """
    if words_in(strings).isdisjoint(robot.groups):
        return replace(robot, assumes_names=True)
    return robot


def _detect(
    given: Collection[str],
    robots: Mapping[str, RobotNames],
    hints: Iterable[Hint],
    listed: Collection[str],
    by_parts: bool,
) -> Robot:
    words = words_in(given)
    fits = {
        name: _fit(robot, words | _built(robot, words), given) for name, robot in robots.items()
    }
    best = max((fit.rank for fit in fits.values()), default=(0, 0))
    fitting = [name for name, fit in fits.items() if fit.says_anything and fit.rank == best]
    certain = [name for name in fitting if fits[name].is_certain]
    if certain:
        return _of_certain(certain, robots, fits, hints)
    # Numbers fit every arm, and what is plain fits any: here a name must say which one it is.
    if any(_covers(robots[name], fits[name].joints) for name in fitting):
        verdict = decide(fitting, robots, hints)
        if verdict.reason:
            return replace(load_robot(verdict.left[0]), chosen_by=verdict.reason)
        raise _unknown(robots)
    if by_parts:
        raise _unknown(robots)
    verdict = decide(robots, robots, (hint for hint in hints if hint.is_telling))
    if verdict.reason and set(listed) <= set(robots[verdict.left[0]].joints):
        robot = load_robot(verdict.left[0])
        return replace(robot, chosen_by=verdict.reason, assumes_names=True)
    raise _unknown(robots)


def _of_certain(
    names: list[str],
    robots: Mapping[str, RobotNames],
    fits: Mapping[str, _Fit],
    hints: Iterable[Hint],
) -> Robot:
    origin = "inferred from the names in the controller's strings"
    if len(names) == 1:
        return _chosen(names[0], origin)
    own = [name for name in names if fits[name].is_named]
    if len(own) == 1:
        return _chosen(own[0], origin)
    verdict = decide(own or names, robots, hints)
    if verdict.reason:
        return _chosen(verdict.left[0], origin, verdict.reason)
    whole = [name for name in verdict.left if fits[name].is_whole]
    if len(whole) == 1:
        reason = f"of {_listed(names)} only {whole[0]} has no joint beside these"
        return _chosen(whole[0], origin, reason)
    error = SeveralRobotsError(
        f"the controller's strings fit several robots: {_listed(verdict.left)}; "
        "say which one it drives with --robot"
    )
    error.names = verdict.left
    raise error


def _chosen(name: str, origin: str, reason: str = "") -> Robot:
    return replace(load_robot(name), chosen_by=f"{origin}; {reason}" if reason else origin)


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names))


def _unknown(robots: Iterable[str]) -> NoRobotNamedError:
    return NoRobotNamedError(
        "the controller's strings name no joint, link or group of a known robot; "
        f"say which one it drives with --robot; {one_of(robots)}"
    )


def _fit(robot: RobotNames, words: frozenset[str], strings: Collection[str]) -> _Fit:
    joints = words.intersection(robot.joints)
    proper = {name for name in joints if not is_plain(name)}
    stems = {re.sub(r"\d+$", "", joint) for joint in robot.joints}
    stems = {
        stem
        for stem in stems & words
        if len(stem.rstrip("_")) > _SHORTEST_STEM and not is_plain(stem)
    }
    places = words & {*robot.links, *robot.groups, *robot.controllers}
    # Names of whole namespaces (`/robot/limb/right`) stand within longer ones.
    places |= {
        name for name in robot.controllers if "/" in name and any(name[1:] in s for s in strings)
    }
    tellable = {name for name in joints if not is_number(name)}
    names = {robot.name, *robot.aliases} - EVERYDAY
    is_named = any(names & words_in([string]) for string in strings if not re.search(r"\s", string))
    return _Fit(
        joints=frozenset(joints | stems),
        places=frozenset(places),
        is_named=is_named,
        is_certain=bool(proper or stems or is_named)
        or any(not is_plain(name) for name in places)
        or _covers(robot, tellable),
        is_whole=joints.issuperset(robot.arm_joints),
    )


def _built(robot: RobotNames, words: frozenset[str]) -> frozenset[str]:
    """Return the joints and links that two words make: `panda_` before `joint1`."""
    prefixes = {word for word in words if re.fullmatch(r"[A-Za-z]\w*_", word)}
    return frozenset(
        name
        for name in (*robot.joints, *robot.links)
        for prefix in prefixes
        if name.startswith(prefix) and name.removeprefix(prefix) in words
    )


def _covers(robot: RobotNames, joints: Collection[str]) -> bool:
    """Return whether half of the joints of an arm of the robot, and more than a few, are named."""
    return any(
        len(set(joints) & set(group)) >= max(_FEWEST, _HALF * len(group))
        for group in robot.groups.values()
    )


class _Once:
    """Hints that are asked for more than once, and read from their files but once."""

    def __init__(self, hints: Iterable[Hint]) -> None:
        self._coming = iter(hints)
        self._read: list[Hint] = []

    def __iter__(self) -> Iterator[Hint]:
        yield from self._read
        for hint in self._coming:
            self._read.append(hint)
            yield hint
