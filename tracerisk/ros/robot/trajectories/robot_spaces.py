"""Which robots of the same joints a controller drives, each in a namespace of its own."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.robots.robot import Robot

_LEAST = 3  # parts of a name: the namespace, a controller, and what it takes
_FEWEST_JOINTS = 4  # of what is an arm
_SIDE = re.compile(r"(?<![a-z])(?:left|right)(?=arm|robot|[^a-z]|$)")
_NUMBERED = re.compile(
    r"(?:(?<=arm)|(?<=robot)|(?<=panda)|(?<=franka)|(?<=iiwa)|(?<=xarm)|(?<=manipulator)|"
    r"(?<=ur\d)|(?<=ur\de)|(?<=ur10)|(?<=ur10e))_?[12](?![0-9a-z])"
    # A number that counts the joints of one arm: `/arm_1_joint/command`.
    r"(?!_(?:joint|link|motor|servo)(?:_(?:position|velocity|effort|controller)\w*)?(?:/|$))"
)
# What has sides and is no arm.
_NO_ARM = re.compile(
    r"gripper|hand|finger|camera|image|depth|marker|wheel|light|(?<![a-z])leds?(?![a-z])|button"
    r"|wrench|sensor|foot"
)
_STATES = re.compile(r"(?:\w*State|JointStates?)$")


class RobotSpaces:
    """Looks for joints that are commanded by one controller's name in several namespaces.

    They are joints of several robots, and the twin is one.
    """

    def __init__(self, runtime: Runtime | None = None) -> None:
        del runtime
        self._spaces: dict[tuple[str, frozenset[str]], str] = {}
        self._noted: set[str] = set()

    @property
    def has_noted(self) -> bool:
        """Whether the controller commanded joints in a second namespace."""
        return bool(self._noted)

    def other(self, name: str, joints: Iterable[str]) -> str:
        """Return words for the first command in one more namespace, empty for none."""
        space, *rest = name.strip("/").split("/")
        if 1 + len(rest) < _LEAST:
            return ""
        first = self._spaces.setdefault(("/".join(rest), frozenset(joints)), space)
        if first == space or space in self._noted:
            return ""
        self._noted.add(space)
        return (
            f"the controller commands the same joints in the namespaces '/{first}' and '/{space}': "
            "the twin is one robot, which both move"
        )


def arms_spoken_of(names: Iterable[str]) -> tuple[str, str] | None:
    """Return two names that differ in the arm alone: `/left/arm_goal` and `/right/arm_goal`."""
    known: dict[str, dict[str, str]] = {}
    for name in sorted(names):
        lowered = name.lower()
        for pattern in (_SIDE, _NUMBERED) if not _NO_ARM.search(lowered) else ():
            sides = {side.lstrip("_") for side in pattern.findall(lowered)}
            if len(sides) == 1:
                known.setdefault(pattern.sub("*", lowered), {}).setdefault(min(sides), name)
    pairs = (tuple(by_side.values())[:2] for by_side in known.values() if len(by_side) > 1)
    return next(((first, second) for first, second in pairs), None)


def has_several_arms(robot: Robot) -> bool:
    """Return whether a robot has arms that move without each other."""
    own = {joint.name for joint in robot.arm_joints}
    arms = [own.intersection(group.joints) for group in robot.groups.values()]
    arms = [joints for joints in arms if len(joints) >= _FEWEST_JOINTS]
    return any(first.isdisjoint(second) for first, second in combinations(arms, 2))


def group_of_side(robot: Robot, name: str) -> str | None:
    """Return the arm of a robot with two that the name of an interface means, `None` for none.

    It is the largest group of joints of that side, else the largest with the side in its name.
    """
    sides = _sides_in(name)
    if len(sides) != 1 or not has_several_arms(robot):
        return None
    own = {joint.name for joint in robot.arm_joints}
    groups = {
        group: known.joints
        for group, known in robot.groups.items()
        if known.joints and own.issuperset(known.joints)
    }
    by_joints = [
        group for group, joints in groups.items() if all(_sides_in(one) == sides for one in joints)
    ]
    meant = by_joints or [group for group in groups if _sides_in(group) == sides]
    return max(meant, key=lambda group: len(groups[group]), default=None)


def _sides_in(name: str) -> set[str]:
    return set(_SIDE.findall(name.lower()))


def words_of_several_arms(runtime: Runtime) -> str:
    """Return what to say where a controller drives two arms and the twin has one; else nothing.

    It sends to both, or asks for the states of both.
    """
    if has_several_arms(runtime.twin.robot) or runtime.client(RobotSpaces).has_noted:
        return ""
    graph = runtime.graph
    heard = {name for name, type_name in graph.heard_topics() if _STATES.search(type_name)}
    pair = arms_spoken_of(graph.counts) or arms_spoken_of(heard)
    if pair is None:
        return ""
    return (
        f"the controller speaks to two arms, {pair[0]} and {pair[1]}, and robot "
        f"'{runtime.twin.robot.name}' has one, which stands for both: name a robot with two "
        "arms with --robot"
    )
