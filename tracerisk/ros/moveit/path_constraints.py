"""What moveit_msgs/Constraints allow: whether a state keeps to them, and how far it is off."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.ros.transforms.poses import (
    Quaternion,
    compose,
    conjugate,
    goal_quaternion,
    multiply,
    rpy_from_quaternion,
    unit_quaternion,
)
from tracerisk.twin.physics.motion import Pose

BOX, SPHERE, CYLINDER = 1, 2, 3
"""Types of shape_msgs/SolidPrimitive."""
_SLACK = 1e-6
_WITHIN = 0.9  # of a tolerance: what a path is brought to, so that it keeps the whole between

Array = NDArray[np.float64]
Forward = Callable[[Mapping[str, float], str], Pose]
Frame = Callable[[str], Pose | None]


class PathRule:
    """The constraints that a path or a goal must keep to; those of `moveit_msgs/Constraints`.

    `forward(positions, link)` gives a link's pose, `frame(name)` that of a frame, both in the
    planning frame; `link` is the link of constraints that name none, `slack` how far beyond a bound
    still counts as within [rad or m]. What cannot be checked counts as a breach, with the reason.
    """

    def __init__(
        self,
        constraints: Any,
        forward: Forward,
        frame: Frame,
        *,
        link: str = "",
        slack: float = _SLACK,
    ) -> None:
        self._constraints = constraints
        self._link, self._slack = link, slack
        self._forward = forward
        # The rule is of one plan, in which nothing moves; it is looked at very many times.
        self._frame = cache(frame)
        self._turns = cache(self._turn)

    @property
    def is_empty(self) -> bool:
        """Whether it allows everything."""
        kinds = ("joint", "orientation", "position", "visibility")
        return not any(len(getattr(self._constraints, f"{kind}_constraints")) for kind in kinds)

    def breach(self, positions: Mapping[str, float]) -> str | None:
        """Return the first breach at joint positions [rad or m] in words, None for none."""
        if self._constraints.visibility_constraints:
            return "visibility constraints cannot be checked: the twin has no cameras"
        return next((part.words for part in self._parts(positions) if part.is_broken), None)

    def excess(self, positions: Mapping[str, float]) -> Array:
        """Return how far each part of the rule is beyond nine tenths of what is allowed.

        Returns: (n_parts,) [rad or m], 0 within; NaN for what cannot be checked.
        """
        return np.array([part.excess for part in self._parts(positions)])

    def _parts(self, positions: Mapping[str, float]) -> Iterator[_Part]:
        for one in self._constraints.joint_constraints:
            value = positions.get(one.joint_name)
            if value is not None:
                yield _joint_part(one, value, self._slack)
        for one in self._constraints.orientation_constraints:
            yield from self._orientation_parts(one, positions)
        for one in self._constraints.position_constraints:
            yield from self._position_parts(one, positions)

    def _orientation_parts(self, one: Any, positions: Mapping[str, float]) -> Iterator[_Part]:
        q = one.orientation
        back = self._turns(one.header.frame_id, (q.x, q.y, q.z, q.w))
        if back is None:
            yield _unknown(
                f"an orientation constraint is in the unknown frame '{one.header.frame_id}'"
            )
            return
        link = one.link_name or self._link
        error = multiply(back, self._forward(positions, link).orientation)
        for axis, angle in zip("xyz", rpy_from_quaternion(error), strict=True):
            tolerance = getattr(one, f"absolute_{axis}_axis_tolerance")
            words = (
                f"link '{link}' is turned by {abs(angle):.3f} rad about {axis}, "
                f"{tolerance:.3f} are allowed"
            )
            is_broken = abs(angle) > tolerance + self._slack
            yield _Part(is_broken, _beyond(angle, tolerance), words)

    def _turn(self, frame: str, turn: Quaternion) -> Quaternion | None:
        """Return the turn back from what is wanted in a frame, None where nobody has the frame."""
        base = self._frame(frame)
        if base is None:
            return None
        return conjugate(multiply(base.orientation, goal_quaternion(turn)))

    def _position_parts(self, one: Any, positions: Mapping[str, float]) -> Iterator[_Part]:
        base = self._frame(one.header.frame_id)
        if base is None:
            yield _unknown(f"a position constraint is in the unknown frame '{one.header.frame_id}'")
            return
        region = one.constraint_region
        if region.meshes:
            message = "a position constraint has a mesh as its region, which cannot be checked"
            yield _unknown(message)
            return
        offset, link = one.target_point_offset, one.link_name or self._link
        point = compose(
            self._forward(positions, link),
            Pose((offset.x, offset.y, offset.z), (0.0, 0.0, 0.0, 1.0)),
        ).position
        words = (
            f"link '{one.link_name or self._link}' is outside the region of its position constraint"
        )
        shapes = [
            (shape, _seen_from(compose(base, message_pose(pose)), point))
            for shape, pose in zip(region.primitives, region.primitive_poses, strict=False)
        ]
        outside = [_outside(shape, seen) for shape, seen in shapes]
        nearest = min(outside, key=lambda row: sum(map(abs, row)), default=(math.nan,) * 3)
        is_broken = not any(_is_inside(shape, seen, self._slack) for shape, seen in shapes)
        for value in nearest:
            yield _Part(is_broken, value, words)


@dataclass(frozen=True, slots=True)
class _Part:
    """The check of one bound of a path constraint."""

    is_broken: bool
    """Whether the bound is violated."""
    excess: float
    """The signed distance beyond the bound [rad or m]; not a number where it is unknown."""
    words: str
    """The violation in words."""


def _unknown(words: str) -> _Part:
    return _Part(True, math.nan, words)


def _joint_part(one: Any, value: float, slack: float) -> _Part:
    low, high = one.position - one.tolerance_below, one.position + one.tolerance_above
    words = f"joint '{one.joint_name}' at {value:.4f} is outside [{low:.4f}, {high:.4f}]"
    is_broken = not low - slack <= value <= high + slack
    return _Part(is_broken, _beyond(value - (low + high) / 2, (high - low) / 2), words)


def _beyond(value: float, tolerance: float) -> float:
    """Return how far a value is from nine tenths of +-tolerance, with its sign; 0 within."""
    rest = abs(value) - _WITHIN * tolerance
    return math.copysign(rest, value) if rest > 0.0 else 0.0


def _outside(shape: Any, point: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return how far a point is outside a shape, along the shape's axes [m]."""
    x, y, z = point
    sizes = [float(value) for value in shape.dimensions]
    if shape.type == BOX:
        return _beyond(x, sizes[0] / 2), _beyond(y, sizes[1] / 2), _beyond(z, sizes[2] / 2)
    if shape.type == SPHERE:
        return _shortened((x, y, z), sizes[0])
    if shape.type == CYLINDER:
        across = _shortened((x, y, 0.0), sizes[1])
        return across[0], across[1], _beyond(z, sizes[0] / 2)
    return (math.nan,) * 3


def _shortened(point: tuple[float, float, float], radius: float) -> tuple[float, float, float]:
    length = math.hypot(*point)
    share = _beyond(length, radius) / length if length > 0.0 else 0.0
    return point[0] * share, point[1] * share, point[2] * share


def is_within(one: Any, base: Pose, point: tuple[float, float, float]) -> bool:
    """Return whether a point is in the region of a position constraint; `base` is its frame's."""
    region = one.constraint_region
    return any(
        _is_inside(shape, _seen_from(compose(base, message_pose(pose)), point), _SLACK)
        for shape, pose in zip(region.primitives, region.primitive_poses, strict=False)
    )


def message_pose(message: Any) -> Pose:
    """Return a geometry_msgs/Pose as the twin's; a turn of all zeros is no turn."""
    p, q = message.position, message.orientation
    return Pose((float(p.x), float(p.y), float(p.z)), unit_quaternion((q.x, q.y, q.z, q.w)))


def _seen_from(place: Pose, point: tuple[float, float, float]) -> tuple[float, float, float]:
    back = conjugate(place.orientation)
    px, py, pz = place.position
    moved = Pose((point[0] - px, point[1] - py, point[2] - pz), (0.0, 0.0, 0.0, 1.0))
    return compose(Pose((0.0, 0.0, 0.0), back), moved).position


def _is_inside(shape: Any, point: tuple[float, float, float], slack: float) -> bool:
    x, y, z = point
    sizes = [float(value) + slack for value in shape.dimensions]
    if shape.type == BOX:
        return all(abs(part) <= size / 2 for part, size in zip(point, sizes, strict=True))
    if shape.type == SPHERE:
        return math.hypot(x, y, z) <= sizes[0]
    if shape.type == CYLINDER:
        return abs(z) <= sizes[0] / 2 and math.hypot(x, y) <= sizes[1]
    return False
