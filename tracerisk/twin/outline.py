"""What robot files leave out: outlines from the lengths of links, servos from rated figures."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from tracerisk.twin.robot import Attachment, Link, Servo
from tracerisk.twin.shapes import Shape

_SHORTEST = 0.005  # a frame nearer than this to its parent has no length to fill [m]

# Own: with these the set-points of arms from 1 N m to 500 N m are tracked in simulation.
_STIFFNESS = 25.0  # of the servo, by rated torque [1/rad]
_DAMPING = 0.1  # of the servo, by its stiffness [s]
_ARMATURE = 0.012  # by rated torque [s^2], at most that of a large strain-wave drive
_LARGEST_ARMATURE = 0.4  # [kg m^2]
_FRICTION = 0.05  # the share of the rated torque that goes into friction at the rated speed
_LARGEST_FRICTION = 1.0  # [N m s/rad]


def outlined(link: Link, radius: float | None, attachments: Iterable[Attachment]) -> Link:
    """Return the link with a capsule of `radius` [m] from its frame to each that hangs on it.

    A link from whose frame nothing leads away gets a ball. `None` leaves the link as it is.
    """
    if radius is None:
        return link
    spans = [a.xyz for a in attachments if a.parent == link.name]
    shapes = [_capsule(span, radius) for span in spans if math.hypot(*span) > _SHORTEST]
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


def _capsule(span: tuple[float, float, float], radius: float) -> Shape:
    """Return the capsule from the origin to `span`, turned from z to its direction."""
    x, y, z = span
    length = math.hypot(x, y, z)
    return Shape(
        "capsule",
        (radius, length / 2),
        xyz=(x / 2, y / 2, z / 2),
        rpy=(0.0, math.acos(z / length), math.atan2(y, x)),
    )
