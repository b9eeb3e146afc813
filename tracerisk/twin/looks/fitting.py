"""Which look fits a robot: by the ends of its links' names and how they hang on one another.

A look is made for one robot and fits all that are built alike, smaller or larger ones and those
that a user describes, whatever their names.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tracerisk.common.geometry.frames import rotation
from tracerisk.twin.looks.look import Look, Piece, Point, is_called, scaled
from tracerisk.twin.looks.shipped_looks import shipped_looks
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Attachment

_NOTHING = 0.012  # lengths below this say nothing of the size of an arm [m]
_MOST = 3.5  # times as long as in the robot that the look is made for, or as short
_TURNED = 0.02  # [rad]


@dataclass(frozen=True, slots=True)
class _Fit:
    look: Look
    """The look."""
    links: Mapping[str, str]
    """Links of the robot by the names that the look has for them."""
    along: Mapping[str, Point]
    """How many times as long each link is along its axes."""
    across: float
    """How many times as large the robot is as the one that the look is made for."""
    unlike: float
    """How much the lengths of links differ beyond that; 0 for the robot itself."""


def look_of(robot: Robot) -> dict[str, tuple[Piece, ...]]:
    """Return what is drawn of the links for which a shipped look fits, by their names."""
    fits = [fit for look in shipped_looks() if (fit := _fit(robot, look)) is not None]
    drawn: dict[str, tuple[Piece, ...]] = {}
    for fit in sorted(fits, key=lambda fit: (-len(fit.links), fit.unlike, fit.look.name)):
        if not drawn.keys() & set(fit.links.values()):
            for name, link in fit.links.items():
                drawn[link] = scaled(fit.look.links[name], fit.along[name], fit.across)
    return drawn


def _fit(robot: Robot, look: Look) -> _Fit | None:
    """Return how a look fits a robot; `None` where it does not."""
    links: dict[str, str] = {}
    for name in look.links:
        named = [link for link in robot.link_names if is_called(link, name)]
        if not named:
            return None
        links[name] = min(named, key=len)
    made_for = load_robot(look.made_for)
    own = {(hung.parent, hung.child): hung for hung in robot.attachments}
    pairs: list[tuple[str, Attachment, Attachment]] = []
    for theirs in made_for.attachments:
        parent, child = (_named(link, look) for link in (theirs.parent, theirs.child))
        if parent is None or child is None:
            continue
        ours = own.get((links[parent], links[child]))
        if ours is None or not _turned_alike(theirs, ours):
            return None
        pairs.append((parent, theirs, ours))
    return _sized(look, links, pairs)


def _sized(
    look: Look, links: Mapping[str, str], pairs: list[tuple[str, Attachment, Attachment]]
) -> _Fit | None:
    before = sum(math.hypot(*theirs.xyz) for _, theirs, _ in pairs)
    across = sum(math.hypot(*ours.xyz) for *_, ours in pairs) / before if before else 1.0
    along = {name: [across] * 3 for name in links}
    unlike = 0.0
    for parent, theirs, ours in pairs:
        for axis, (length, own) in enumerate(zip(theirs.xyz, ours.xyz, strict=True)):
            if abs(length) < _NOTHING:
                if abs(own) > 2 * _NOTHING:
                    return None
                continue
            ratio = own / length
            if not 1.0 / _MOST < ratio < _MOST:
                return None
            along[parent][axis] = ratio
            unlike += abs(math.log(ratio / across))
    return _Fit(
        look,
        links,
        {name: (axes[0], axes[1], axes[2]) for name, axes in along.items()},
        across,
        unlike + abs(math.log(across)),
    )


def _turned_alike(one: Attachment, other: Attachment) -> bool:
    """Return whether two links hang on their parents with the same turn and axis."""
    between = rotation(one.rpy).T @ rotation(other.rpy)
    angle = math.acos(min(max((float(np.trace(between)) - 1.0) / 2.0, -1.0), 1.0))
    if angle > _TURNED:
        return False
    if "fixed" in (one.type, other.type):
        return one.type == other.type
    axes = np.array(one.axis), np.array(other.axis)
    across = np.linalg.norm(np.cross(*axes)) / np.linalg.norm(axes[0]) / np.linalg.norm(axes[1])
    return bool(across < _TURNED)


def _named(link: str, look: Look) -> str | None:
    """Return what a look calls a link; `None` where it draws nothing of it."""
    return next((name for name in look.links if is_called(link, name)), None)
