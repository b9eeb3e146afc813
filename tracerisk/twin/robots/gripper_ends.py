"""Where a gripper is closed and where it is open: known from the distance of its pads.

Some grippers open while their first joint grows, others close (Robotiq, xArm, Kinova): the joint
says nothing about it, so nobody else decides which end is which.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tracerisk.common.geometry.frames import Matrix, about, rotation
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper

_ALIKE_M = 1e-4  # ends at which the pads are as far apart do not differ [m]
_HALVINGS = 40  # of the range, until a position is found: to 1e-12 of it


@dataclass(frozen=True, slots=True)
class GripperEnds:
    """The two ends of a gripper, as positions of its first joint."""

    closed: float
    """Where the pads are nearest to each other [m or rad]."""
    opened: float
    """Where they are furthest apart [m or rad]."""

    def share(self, position: float) -> float:
        """Return how far a position is open: 0 closed, 1 wide open."""
        return (position - self.closed) / (self.opened - self.closed)

    def position(self, share: float) -> float:
        """Return the position of a share of the opening [m or rad]."""
        return self.closed + share * (self.opened - self.closed)


@lru_cache(maxsize=16)  # found from where the pads are, and asked for at each state of a gripper
def gripper_ends(robot: Robot, gripper: Gripper) -> GripperEnds:
    """Return the ends of a gripper's range.

    Where the pads do not say which is which (a single one, or both ends alike) its named states
    do, else the greatest position counts as open.
    """
    at_least, at_most = (
        pad_distance(robot, gripper, end) for end in (gripper.least, gripper.opening)
    )
    opens_by_growing = at_most >= at_least
    if abs(at_most - at_least) < _ALIKE_M:
        named = _named(robot, gripper)
        opens_by_growing = named is None or named.opened > named.closed
    if opens_by_growing:
        return GripperEnds(gripper.least, gripper.opening)
    return GripperEnds(gripper.opening, gripper.least)


def driver_ends(robot: Robot, gripper: Gripper) -> GripperEnds:
    """Return what a gripper's driver calls closed and open: its named states, else its ends."""
    ends, named = gripper_ends(robot, gripper), _named(robot, gripper)
    if named is None or (named.opened > named.closed) != (ends.opened > ends.closed):
        return ends
    return named


def width_at(robot: Robot, gripper: Gripper, position: float) -> float:
    """Return how much further the pads are apart at a position than when closed [m]."""
    closed = gripper_ends(robot, gripper).closed
    if robot.joint(gripper.joints[0]).type == "prismatic":
        return abs(position - closed) * len(gripper.joints)
    return pad_distance(robot, gripper, position) - pad_distance(robot, gripper, closed)


def position_at(robot: Robot, gripper: Gripper, width: float) -> float:
    """Return the position at which the pads are a width further apart than when closed [m or rad].

    For a width that it does not reach it is an end of a gripper that turns; one that slides would
    go on.
    """
    ends = gripper_ends(robot, gripper)
    if robot.joint(gripper.joints[0]).type == "prismatic":
        share = width / len(gripper.joints) / abs(ends.opened - ends.closed)
        return ends.position(share)
    wanted = width + pad_distance(robot, gripper, ends.closed)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if pad_distance(robot, gripper, ends.position(middle)) < wanted:
            low = middle
        else:
            high = middle
    return ends.position(high)


def pad_distance(robot: Robot, gripper: Gripper, position: float) -> float:
    """Return how far the first pad is from the middle of the others [m]; 0 for one or none."""
    at = {name: gripper.sign(name) * position for name in gripper.joints}
    centres = pad_centres(robot, gripper, at)
    if len(centres) < 2:
        return 0.0
    return float(np.linalg.norm(centres[0] - np.mean(centres[1:], axis=0)))


def pad_centres(robot: Robot, gripper: Gripper, at: Mapping[str, float]) -> tuple[Matrix, ...]:
    """Return the centre of each pad in the robot's base, (3,) each [m].

    `at` are positions of joints [rad or m]; those that it leaves out are at 0.
    """
    links = {link.name: link for link in robot.links}
    centres = []
    for name in gripper.pads:
        marked = [shape.xyz for shape in links[name].shapes if shape.pad] or [(0.0, 0.0, 0.0)]
        centres.append(_in_base(robot, name, np.mean(marked, axis=0), at))
    return tuple(centres)


def grasp_from(robot: Robot, gripper: Gripper, link: str) -> tuple[float, float, float]:
    """Return where the pads meet when they close, as a link sees it [m]; joints are at 0."""
    closed = gripper_ends(robot, gripper).closed
    at = {name: gripper.sign(name) * closed for name in gripper.joints}
    middle = np.mean(pad_centres(robot, gripper, at), axis=0)
    origin, *ends = (_in_base(robot, link, point, at) for point in (np.zeros(3), *np.eye(3)))
    x, y, z = (float((end - origin) @ (middle - origin)) for end in ends)
    return x, y, z


def _in_base(robot: Robot, link: str, point: Matrix, at: Mapping[str, float]) -> Matrix:
    """Return a point of a link as the robot's base sees it."""
    for joint in robot.above(link):
        position = at.get(joint.name, 0.0)
        if joint.type == "prismatic":
            axis = np.asarray(joint.axis)
            point = point + position * axis / np.linalg.norm(axis)
        elif joint.type != "fixed":
            point = about(joint.axis, position) @ point
        point = rotation(joint.rpy) @ point + joint.xyz
    return point


def _named(robot: Robot, gripper: Gripper) -> GripperEnds | None:
    """Return the positions of the named states that close and open a gripper, if it has both."""
    values: dict[str, float] = {}
    for name, state in robot.named_states.get(gripper.group, {}).items():
        own = {joint: state[joint] for joint in gripper.joints if joint in state}
        word = name.lower()[: len("open")]
        if own and word in ("open", "clos"):
            values.setdefault(word, gripper.position(own))
    if len(values) < 2 or values["clos"] == values["open"]:
        return None
    return GripperEnds(values["clos"], values["open"])
