"""What robot files leave out: outlines from the lengths of links, servos from rated figures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Protocol

import numpy as np

from tracerisk.common.geometry.frames import Triple, rotation, triple
from tracerisk.common.geometry.shapes import Shape
from tracerisk.twin.robots.robot_parts import Attachment, Link, Servo

_SHORTEST = 0.005  # a frame nearer than this to its parent has no length to fill [m]
_STRAIGHT = 0.02  # a link whose corner is nearer than this to an end is straight [m]

# Own: with these the set-points of arms from 1 N m to 500 N m are tracked in simulation.
_STIFFNESS = 25.0  # of the servo, by rated torque [1/rad]
_DAMPING = 0.1  # of the servo, by its stiffness [s]
_ARMATURE = 0.012  # by rated torque [s^2], at most that of a large strain-wave drive
_LARGEST_ARMATURE = 0.4  # [kg m^2]
_FRICTION = 0.05  # the share of the rated torque that goes into friction at the rated speed
_LARGEST_FRICTION = 1.0  # [N m s/rad]
_GRAVITY = 9.81  # [m/s^2]


def outlined(link: Link, radius: float | None, attachments: Iterable[Attachment]) -> Link:
    """Return the link with capsules of `radius` [m] from its frame to each that hangs on it.

    A link from whose frame nothing leads away gets a ball. `None` leaves the link as it is.
    """
    if radius is None:
        return link
    shapes = [
        _capsule(begin, end, radius)
        for attachment in attachments
        if attachment.parent == link.name
        for begin, end in _legs(attachment)
        if math.dist(begin, end) > _SHORTEST
    ]
    if not shapes:
        shapes = [Shape("sphere", (radius,))]
    return replace(link, shapes=(*link.shapes, *shapes))


def derived_servo(torque: float, velocity: float) -> Servo:
    """Return a position servo for a joint of rated torque [N m or N] and speed [rad/s or m/s]."""
    stiffness = _STIFFNESS * torque
    return Servo(
        stiffness=stiffness,
        damping=_DAMPING * stiffness,
        armature=min(_ARMATURE * torque, _LARGEST_ARMATURE),
        friction=min(_FRICTION * torque / velocity, _LARGEST_FRICTION),
    )


def _legs(attachment: Attachment) -> list[tuple[Triple, Triple]]:
    """Return the pieces of a link, from its frame to one that hangs on it.

    As Denavit and Hartenberg take a link apart: first across to the axis of the next joint, which
    is the arm's tube, then along that axis, where the housing of the joint is. A straight line
    would cut the corner, through the room in which the wrist of many arms turns.
    """
    span = np.array(attachment.xyz)
    axis = rotation(attachment.rpy) @ np.array(attachment.axis)
    axis = axis / np.linalg.norm(axis)
    along = float(span @ axis)
    corner = span - along * axis
    zero = (0.0, 0.0, 0.0)
    if attachment.type == "fixed" or min(abs(along), float(np.linalg.norm(corner))) < _STRAIGHT:
        return [(zero, attachment.xyz)]
    bend = triple(corner)
    return [(zero, bend), (bend, attachment.xyz)]


def _capsule(begin: Triple, end: Triple, radius: float) -> Shape:
    """Return the capsule between two points, turned from z to its direction."""
    x, y, z = (float(b - a) for a, b in zip(begin, end, strict=True))
    length = math.hypot(x, y, z)
    return Shape(
        "capsule",
        (radius, length / 2),
        xyz=(begin[0] + x / 2, begin[1] + y / 2, begin[2] + z / 2),
        rpy=(0.0, math.acos(z / length), math.atan2(y, x)),
    )


class Hung(Protocol):
    """A link and how it hangs on another, as robots and trees of URDF have it."""

    @property
    def parent(self) -> str:
        """The link on which it hangs."""

    @property
    def child(self) -> str:
        """The link."""

    @property
    def xyz(self) -> tuple[float, float, float]:
        """Where it hangs there [m]."""


def weight_behind(child: str, kind: str, links: Iterable[Link], hung: Iterable[Hung]) -> float:
    """Return the most that the weight of a link and of those behind it can ask of its joint.

    They are stretched, and the axis is level. In [N m], for a joint that slides in [N].
    """
    by_name = {link.name: link for link in links}
    below: dict[str, list[Hung]] = {}
    for one in hung:
        below.setdefault(one.parent, []).append(one)
    total = 0.0
    waiting = [(child, 0.0)]
    while waiting:
        link, away = waiting.pop()
        body = by_name[link]
        lever = 1.0 if kind == "prismatic" else away + math.hypot(*body.centre_of_mass)
        total += body.mass * _GRAVITY * lever
        waiting += [(one.child, away + math.hypot(*one.xyz)) for one in below.get(link, ())]
    return total
