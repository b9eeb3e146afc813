"""Robots whose links and joints bear a prefix, as in a cell where several arms stand."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from tracerisk.twin.robots.index import RobotNames
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_names import is_number

_FEWEST = 4  # joints, which a prefix must stand before
_ENDS = ("_", "/", "-")


def prefix_in(words: Iterable[str], robots: Iterable[RobotNames]) -> str:
    """Return what stands before all joints of an arm of one of the robots; empty for nothing.

    Of several prefixes none is taken: they are of several arms.
    """
    known = frozenset(words)
    prefixes = set[str]()
    for group in {joints for robot in robots for joints in robot.groups.values()}:
        prefixes |= _before(group, known)
    return prefixes.pop() if len(prefixes) == 1 else ""


def prefix_before(joints: Sequence[str], words: Iterable[str]) -> str:
    """Return what stands before all `joints` among the words; empty for nothing, or several."""
    before = _before(joints, frozenset(words))
    return before.pop() if len(before) == 1 else ""


def _before(joints: Sequence[str], known: frozenset[str]) -> set[str]:
    if len(joints) < _FEWEST:
        return set()
    return {
        prefix
        for word in known
        if (prefix := word.removesuffix(joints[0])).endswith(_ENDS)
        and all(f"{prefix}{name}" in known for name in joints)
    }


def prefix_left_out(joints: Sequence[str], named: Iterable[str]) -> str:
    """Return what stands before all `joints` and is left out in `named`; empty for nothing.

    The names without it are those that are named, each of them and no other.
    """
    known = frozenset(named)
    if len(joints) < _FEWEST or len(joints) != len(known):
        return ""
    cuts = (joints[0][:end] for end in range(1, len(joints[0])))
    return next(
        (
            prefix
            for prefix in cuts
            if prefix.endswith(_ENDS) and {*joints} == {f"{prefix}{name}" for name in known}
        ),
        "",
    )


def with_prefix(robot: Robot, prefix: str) -> Robot:
    """Return the robot with `prefix` before the names of its links and joints.

    Groups and controllers keep their names; those that a controller asks for are assumed.
    """
    return renamed(robot, lambda name: f"{prefix}{name}")


def without_prefix(robot: Robot, prefix: str) -> Robot:
    """Return the robot without `prefix` before the names of its links and joints that bear it.

    A name that is another's without the prefix keeps it.
    """
    parts = {*robot.link_names, *(joint.name for joint in robot.joints)}
    return renamed(
        robot,
        lambda name: name if name.removeprefix(prefix) in parts else name.removeprefix(prefix),
    )


def with_numbered(robot: Robot, listed: Sequence[str]) -> Robot | None:
    """Return the robot with the joints of its arm called as they are listed: `joint1` and so on.

    `None` where the names do not count its joints, or the robot has one of that name.
    """
    own = [joint.name for joint in robot.arm_joints]
    numbers = [re.search(r"\d+$", name) for name in listed]
    counted = [int(number[0]) for number in numbers if number is not None]
    if len(own) < _FEWEST or len(listed) != len(own) or not all(map(is_number, listed)):
        return None
    if counted not in (list(range(len(own))), list(range(1, len(own) + 1))):
        return None
    if not {joint.name for joint in robot.joints}.isdisjoint(listed):
        return None
    names = dict(zip(own, listed, strict=True))
    return renamed(robot, lambda name: names.get(name, name))


def renamed(robot: Robot, named: Callable[[str], str]) -> Robot:
    """Return the robot with its links, joints and actuators as `named` calls them."""

    def all_named(names: Iterable[str]) -> tuple[str, ...]:
        return tuple(named(name) for name in names)

    def state(values: Mapping[str, float]) -> Mapping[str, float]:
        return MappingProxyType({named(name): value for name, value in values.items()})

    return replace(
        robot,
        base_link=named(robot.base_link),
        links=tuple(replace(link, name=named(link.name)) for link in robot.links),
        attachments=tuple(
            replace(one, name=named(one.name), parent=named(one.parent), child=named(one.child))
            for one in robot.attachments
        ),
        joints=tuple(replace(joint, name=named(joint.name)) for joint in robot.joints),
        groups=MappingProxyType(
            {
                name: replace(
                    group,
                    joints=all_named(group.joints),
                    tip_link=named(group.tip_link) if group.tip_link else None,
                )
                for name, group in robot.groups.items()
            }
        ),
        named_states=MappingProxyType(
            {
                group: MappingProxyType({name: state(values) for name, values in states.items()})
                for group, states in robot.named_states.items()
            }
        ),
        initial_state=state(robot.initial_state),
        grippers=tuple(
            replace(one, joints=all_named(one.joints), pads=all_named(one.pads))
            for one in robot.grippers
        ),
        controllers=tuple(replace(one, joints=all_named(one.joints)) for one in robot.controllers),
        disabled_collisions=frozenset(
            (named(one), named(other)) for one, other in robot.disabled_collisions
        ),
        assumes_names=True,
        own_sensors=tuple(one.renamed(named) for one in robot.own_sensors),
        without_encoder=all_named(robot.without_encoder),
        actuators=MappingProxyType(
            {named(name): all_named(joints) for name, joints in robot.actuators.items()}
        ),
    )
