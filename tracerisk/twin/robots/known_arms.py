"""Recognise the shipped robot of another description, and fill in what that lacks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from tracerisk.common.geometry.frames import rotation
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.outline import weight_behind
from tracerisk.twin.robots.prefix import prefix_in, with_prefix
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_names import is_number
from tracerisk.twin.robots.robot_parts import Joint
from tracerisk.twin.robots.sensors import sensors_like

_MATCHES = 0.8  # the share of joint names that two robots of one make have in common
_SAME_LENGTH = 0.03  # [m]
_LEAST_JOINTS = 4  # of fewer joints alike nothing follows
_NEAR_LENGTH, _NEAR_RANGE = 0.01, 0.1  # [m], [rad]: within these two arms are one by shape
_SAME = 1e-6  # lengths of two shipped arms that differ by less are one [m]


def shipped_like(names: Iterable[str]) -> tuple[tuple[str, ...], str]:
    """Return the shipped robots with the greatest share of their joints among the names.

    The other value is what is before all of these joints; empty for nothing.
    """
    shares, prefix = _prefixed_shares(tuple(names))
    return tuple(name for name in shares if shares[name] == max(shares.values())), prefix


def _shares(names: Iterable[str]) -> dict[str, float]:
    """Return the shares of the shipped robots with most of their joints among the names."""
    wanted = set(names)
    shares = {
        shipped_name.name: len(wanted.intersection(shipped_name.arm_joints))
        / len(shipped_name.arm_joints)
        for shipped_name in shipped_names()
    }
    return {name: share for name, share in sorted(shares.items()) if share >= _MATCHES}


def _prefixed_shares(given: Sequence[str]) -> tuple[dict[str, float], str]:
    shares = _shares(given)
    # Behind a prefix, numbers are no arm's own names.
    named = (
        shipped_name
        for shipped_name in shipped_names()
        if not all(map(is_number, shipped_name.arm_joints))
    )
    prefix = "" if shares else prefix_in(given, named)
    return (_shares(name.removeprefix(prefix) for name in given) if prefix else shares), prefix


def _all_shipped_like(names: Iterable[str]) -> Iterator[Robot]:
    """Yield the shipped robots with most of their joints among the names, the best ones first.

    Where that is none, one whose joints are all there with a prefix is yielded with it.
    """
    shares, prefix = _prefixed_shares(tuple(names))
    for name in sorted(shares, key=lambda share: (-shares[share], share)):
        yield with_prefix(load_robot(name), prefix) if prefix else load_robot(name)


@dataclass(frozen=True, slots=True)
class _Ours:
    """The shipped robot that another description is."""

    robot: Robot
    """The shipped robot."""
    names: Mapping[str, str]
    """What it calls each joint of the description that it has."""
    by_shape: bool = False
    """Whether the joints are called otherwise."""


def _ours(robot: Robot) -> _Ours | None:
    """Return the shipped robot that this one is: joints of the same names at the same distances.

    Names alone say little: many arms call their joints `joint1` and so on. Where the names are
    others, it is one with as many joints in the same order at the same distances and of the same
    ranges.
    """
    own = _distances(robot)
    best: tuple[float, Robot] | None = None
    for like in _all_shipped_like(joint.name for joint in robot.arm_joints):
        ours = _distances(like)
        apart = [abs(own[name] - ours[name]) for name in sorted(own.keys() & ours.keys())]
        # The first joint stands on whatever the arm is mounted on.
        same = [value for value in apart if value < _SAME_LENGTH]
        if len(same) < _MATCHES * len(apart):
            continue
        # Of arms that are alike it is the one whose lengths come nearest.
        off = math.fsum(same) / max(len(same), 1)
        if best is None or off < best[0] - _SAME:
            best = off, like
    if best is None:
        return _ours_by_shape(robot, own)
    mine = {joint.name for joint in robot.arm_joints}
    both = [joint.name for joint in best[1].arm_joints if joint.name in mine]
    return _Ours(best[1], dict(zip(both, both, strict=True)))


def _ours_by_shape(robot: Robot, own: Mapping[str, float]) -> _Ours | None:
    arm = robot.arm_joints
    if len(arm) < _LEAST_JOINTS:
        return None
    best: tuple[float, Robot] | None = None
    for shipped in shipped_names():
        if len(shipped.arm_joints) != len(arm):
            continue
        like = load_robot(shipped.name)
        ours = _distances(like)
        pairs = list(zip(arm, like.arm_joints, strict=True))
        lengths = [abs(own[a.name] - ours[b.name]) for a, b in pairs[1:]]
        ranges = [
            max(abs(a.lower - b.lower), abs(a.upper - b.upper))
            for a, b in pairs
            if "continuous" not in (a.type, b.type)
        ]
        if max(lengths) > _NEAR_LENGTH or max(ranges, default=0.0) > _NEAR_RANGE:
            continue
        off = math.fsum(lengths) + math.fsum(ranges)
        if best is None or off < best[0] - _SAME:
            best = off, like
    if best is None:
        return None
    pairs = list(zip(arm, best[1].arm_joints, strict=True))
    return _Ours(best[1], {a.name: b.name for a, b in pairs}, by_shape=True)


def _distances(robot: Robot) -> dict[str, float]:
    """Return how far each arm joint is from the moving one before it, or from the base [m]."""
    moving = {joint.name for joint in robot.arm_joints}
    distances: dict[str, float] = {}
    for attachment in robot.attachments:
        if attachment.name in moving:
            place = np.array(attachment.xyz)
            for above in robot.above(attachment.parent):
                if above.type != "fixed":
                    break
                place = np.array(above.xyz) + rotation(above.rpy) @ place
            distances[attachment.name] = float(np.linalg.norm(place))
    return distances


def is_variant(one: Robot, other: Robot) -> bool:
    """Return whether two robots have joints of the same names, in other places."""
    names = [{joint.name for joint in robot.joints} for robot in (one, other)]
    places = [[(at.name, at.xyz, at.rpy) for at in robot.attachments] for robot in (one, other)]
    return names[0] == names[1] and places[0] != places[1]


def completed_as_ours(robot: Robot, *, knows_motors: bool = False) -> Robot:
    """Return the robot with the rated figures of ours, where one has the same joints.

    A robot that knows its motors keeps torques and servos, and lacks only rated velocities. Limits
    that are placeholders are all taken from ours.
    """
    result = _ours(robot)
    if result is None:
        return robot
    like = result.robot
    ours = {mine: like.joint(name) for mine, name in result.names.items()}
    arm = [joint for joint in robot.arm_joints if joint.name in ours]
    takes_all = not knows_motors and _is_placeholder(robot, arm, ours)
    children = {attachment.name: attachment.child for attachment in robot.attachments}
    joints = tuple(
        _rated(
            joint,
            ours[joint.name],
            robot.approximate,
            knows_motors,
            takes_all,
            weight_behind(children[joint.name], joint.type, robot.links, robot.attachments),
        )
        if joint in arm and ours[joint.name].type == joint.type
        else joint
        for joint in robot.joints
    )
    mine = {joint.name for joint in robot.arm_joints}
    taken = {element.name for element in robot.elements}
    sensors = tuple(
        sensor
        for sensor in sensors_like(like.own_sensors, mine, robot.link_names)
        if sensor.name not in taken
    )
    notes = []
    if takes_all:
        notes.append(
            f"its description gives every joint the same speed, a placeholder: the limits of the "
            f"shipped robot '{like.name}', which has the same joints, are taken"
        )
    elif result.by_shape:
        notes.append(
            f"limits that its file does not give are those of the shipped robot '{like.name}', "
            "whose joints have the same order, distances and ranges"
        )
    return replace(
        robot,
        joints=joints,
        own_sensors=(*robot.own_sensors, *sensors),
        following=like.following,
        assumed_figures=(*robot.assumed_figures, *notes),
    )


def _is_placeholder(robot: Robot, arm: Sequence[Joint], ours: Mapping[str, Joint]) -> bool:
    """Return whether limits are no arm's: one speed and one torque for joints of several kinds.

    A torque that could not lift the arm was replaced already, and the robot is approximate.
    """
    if len(arm) < _LEAST_JOINTS:
        return False
    speeds = {joint.velocity_limit for joint in arm}
    torques = {joint.torque_limit for joint in arm}
    rated = {ours[joint.name].velocity_limit for joint in arm}
    return len(speeds) == 1 < len(rated) and (robot.approximate or len(torques) == 1)


def _rated(
    joint: Joint,
    ours: Joint,
    assumed: bool,
    knows_motors: bool,
    takes_all: bool,
    weight: float,
) -> Joint:
    """Return a joint with what a URDF does not say, and our figures where its own are assumed.

    It keeps its torque where ours could not lift the `weight` of its own links.
    """
    joint = replace(
        joint,
        acceleration_limit=ours.acceleration_limit,
        plan_velocity=ours.plan_velocity,
        plan_acceleration=ours.plan_acceleration,
    )
    if takes_all:
        joint = replace(joint, lower=ours.lower, upper=ours.upper)
    if not assumed and not takes_all:
        return joint
    joint = replace(joint, velocity_limit=ours.velocity_limit)
    if knows_motors or ours.torque_limit < weight:
        return joint
    return replace(joint, torque_limit=ours.torque_limit, servo=ours.servo)


def named_as_ours(robot: Robot) -> Robot:
    """Return a robot without an SRDF with the groups of ours, else one that assumes them."""
    ours = _ours(robot)
    if ours is None or ours.by_shape:
        return replace(robot, approximate=True, assumes_names=True)
    like = ours.robot
    joints = {joint.name: joint for joint in robot.joints}
    groups, states = dict(robot.groups), dict(robot.named_states)
    for name, group in like.groups.items():
        if set(group.joints) <= joints.keys():
            tip = group.tip_link if group.tip_link in robot.link_names else None
            own = next((g for g in robot.groups if robot.groups[g].joints == group.joints), None)
            own_tip = robot.groups[own].tip_link if own is not None else None
            groups[name] = replace(group, tip_link=tip or own_tip)
            own_states = robot.named_states.get(own or name, {})
            # The file's own states go before those of ours.
            states[name] = MappingProxyType({**like.named_states.get(name, {}), **own_states})
    return replace(robot, groups=MappingProxyType(groups), named_states=MappingProxyType(states))
